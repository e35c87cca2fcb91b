// The compliance controller on the arm: INT and the MuJoCo plant.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <gtest/gtest.h>

#include "controllers/compliance.h"
#include "controllers/gravity_hold.h"
#include "controllers/torque_rig.h"
#include "twin/core/joint_vector.h"
#include "twin/model/transform.h"

namespace twin::controllers::controllers_compliance_motion_test {
namespace {

using control::ControllerOutput;
using control::ControllerRequest;
using reference::Trajectory;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1s

const JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};

Trajectory Standing(Duration length) {
  return Trajectory({{.q = kReady, .at = 0s}, {.q = kReady, .at = length}}, {},
                    twin::test::PandaLimits());
}

ControllerRequest RequestOf(const Trajectory& trajectory) {
  return {.trajectory = trajectory,
          .interface = control::CommandInterface::kTorque,
          .limits = twin::test::PandaLimits(),
          .cartesian = twin::test::PandaCartesianLimits()};
}

/// The stiff case of the paper, softer in translation: 1000 or 100 N/m.
ComplianceOptions Soft(double stiffness) {
  ComplianceOptions options;
  options.K_P = {stiffness, stiffness, stiffness, 100, 100, 100};
  const double damping = stiffness / 10;
  options.K_D = {damping, damping, damping, 10, 10, 10};
  return options;
}

/// Where a steady force of `force` N along y takes the flange, m; and how far the rest is moved.
struct Deflection {
  double along = 0;
  double across = 0;
  double after = 0;  ///< once it is gone
};

Deflection PushAside(double stiffness, double force) {
  const Trajectory trajectory = Standing(10s);
  ComplianceController controller(RequestOf(trajectory), Soft(stiffness));
  test::TorqueRig rig(kReady, {plant::Push{.body = "panda_link8",
                                           .begin = 500ms,
                                           .duration = 5500ms,
                                           .rise = 250ms,
                                           .force = {0, force, 0}}});
  const Transform start = rig.O_T_EE();
  Deflection result;
  EXPECT_EQ(rig.Run(controller,
                    [&](Duration t, const ControllerOutput&) {
                      const Vector6 way = model::WayTo(start, rig.O_T_EE());
                      if (t <= 5s) {
                        result.along = way[1];
                        result.across = std::hypot(way[0], way[2]);
                      }
                      result.after = HalfNorm(way, 0);
                    }),
            "");
  std::printf("%.0f N/m, %.0f N: %.3f mm along, %.3f mm across, %.3f mm after\n", stiffness, force,
              1e3 * result.along, 1e3 * result.across, 1e3 * result.after);
  return result;
}

TEST(ComplianceMotionTest, DeflectsByForceOverStiffnessAndComesBack) {
  for (const auto& [stiffness, force] : {std::pair(1000.0, 20.0), {400.0, 20.0}, {100.0, 5.0}}) {
    const Deflection d = PushAside(stiffness, force);
    EXPECT_NEAR(d.along, force / stiffness, 0.1 * force / stiffness);
    EXPECT_LT(d.across, 2e-3);
    EXPECT_LT(d.after, 2e-3);
  }
}

TEST(ComplianceMotionTest, NullSpaceMotionLeavesTheEndEffector) {
  // q0 has another elbow: the arm goes there, the flange stays.
  const Trajectory trajectory = Standing(8s);
  ComplianceOptions options;
  options.k_0 = 10;
  options.q_0 = kReady;
  options.q_0[2] += 1;
  ComplianceController controller(RequestOf(trajectory), options);
  test::TorqueRig rig(kReady);
  const Transform start = rig.O_T_EE();
  double most = 0;
  EXPECT_EQ(rig.Run(controller,
                    [&](Duration, const ControllerOutput&) {
                      most = std::max(most, HalfNorm(model::WayTo(start, rig.O_T_EE()), 0));
                    }),
            "");
  double moved = 0;
  for (std::size_t j = 0; j < kJoints; ++j) {
    moved = std::max(moved, std::abs(rig.state().q[j] - kReady[j]));
  }
  std::printf("joints up to %.3f rad, flange up to %.3f mm\n", moved, 1e3 * most);
  EXPECT_GT(moved, 0.05);
  EXPECT_LT(most, 2e-3);
}

TEST(ComplianceMotionTest, TracksAPathOfPosesUntouched) {
  const Trajectory trajectory = Standing(9s);
  test::TorqueRig rig(kReady);
  const Transform start = rig.O_T_EE();
  Transform aside = start;
  aside[13] += 0.2;
  Transform down = aside;
  down[14] -= 0.15;
  const reference::PoseTrajectory poses({{.O_T_EE = start, .at = 0s},
                                         {.O_T_EE = aside, .at = 3s},
                                         {.O_T_EE = down, .at = 6s},
                                         {.O_T_EE = start, .at = 9s}},
                                        {}, twin::test::PandaCartesianLimits());
  ControllerRequest request = RequestOf(trajectory);
  request.poses = &poses;
  ComplianceController controller(request);
  double most = 0;
  EXPECT_EQ(rig.Run(controller,
                    [&](Duration t, const ControllerOutput&) {
                      const Vector6 way = model::WayTo(rig.O_T_EE(), poses.Sample(t).O_T_EE);
                      most = std::max(most, HalfNorm(way, 0));
                    }),
            "");
  std::printf("off the path by up to %.3f mm\n", 1e3 * most);
  EXPECT_LT(most, 5e-3);
}

TEST(GravityHoldMotionTest, ThePushedArmFloatsAwayAndTheUntouchedOneStays) {
  for (const double force : {0.0, 15.0}) {
    const Trajectory trajectory = Standing(2s);
    GravityHoldOptions options;
    options.K_D.fill(2);
    GravityHoldController controller(RequestOf(trajectory), options);
    test::TorqueRig rig(kReady, {plant::Push{.body = "panda_link8",
                                             .begin = 200ms,
                                             .duration = 1s,
                                             .rise = 100ms,
                                             .force = {0, force, 0}}});
    const Transform start = rig.O_T_EE();
    EXPECT_EQ(rig.Run(controller, [](Duration, const ControllerOutput&) {}), "");
    const double moved = HalfNorm(model::WayTo(start, rig.O_T_EE()), 0);
    std::printf("%.0f N: floats by %.1f mm\n", force, 1e3 * moved);
    if (force == 0) {
      EXPECT_LT(moved, 2e-3);
    } else {
      EXPECT_GT(moved, 0.02);
    }
  }
}

}  // namespace
}  // namespace twin::controllers::controllers_compliance_motion_test

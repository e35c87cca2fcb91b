// Limits of a lab as bounds of a led motion.
#include <array>
#include <string>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/model/arm_model.h"
#include "twin/teleop/motion_guard.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::teleop::teleop_limits_test {
namespace {

constexpr JointVector kReady{0, -0.785, 0, -2.356, 0, 1.571, 0.785};

struct Guarded {
  Vector6 allowed{};
  ActiveBound active;

  Guarded(const model::LabLimits& lab, const Vector6& twist, RobotState state = {}) {
    MotionGuard guard(model::ArmModel::Panda(), twin::test::PandaLimits(), true, nullptr, lab);
    TwistBounds bounds(TeleoperatorConfig().along.speed, TeleoperatorConfig().about.speed);
    state.q = kReady;
    const twin::test::RealtimeGuard realtime;
    guard.AddTo(bounds, {.q = kReady}, {}, state);
    const AllowedTwist closest = bounds.Closest(twist);
    allowed = closest.u;
    active = closest.strongest;
  }
};

/// A wall this far before the end effector along x.
model::LabLimits WallAhead(double distance) {
  const double x = model::ArmModel::Panda().Pose(model::Frame::kEndEffector, kReady)[12];
  return {.regions = {{"wall",
                       {model::LimitedPart::kEndEffector},
                       true,
                       model::HalfSpace{{1, 0, 0}, x + distance}}}};
}

TEST(LedLimitsGuardTest, SlowsTheHandBeforeARegionsEndAndLetsItSlideAlong) {
  const Guarded guarded(WallAhead(0.03), {0.2, 0.1, 0, 0, 0, 0});
  EXPECT_NEAR(guarded.allowed[0], MotionGuard::kDecay * (0.03 - MotionGuard::kRegionMargin), 1e-3);
  EXPECT_NEAR(guarded.allowed[1], 0.1, 1e-3);
  EXPECT_EQ(Describe(guarded.active), "the lab's limit 'wall' ends here");
}

TEST(LedLimitsGuardTest, LeadsTheHandBackFromBeyond) {
  EXPECT_LT(Guarded(WallAhead(-0.05), {0.2, 0.1, 0, 0, 0, 0}).allowed[0], 0);
  EXPECT_NEAR(Guarded(WallAhead(-0.05), {-0.2, 0, 0, 0, 0, 0}).allowed[0], -0.2, 1e-3);
}

TEST(LedLimitsGuardTest, StopsPushingAtTheCapOnForceAndLetsGo) {
  const model::LabLimits lab{.force_max = 40};
  RobotState state;
  state.O_F_ext_hat_K[2] = -40;  // the robot pushes down
  EXPECT_NEAR(Guarded(lab, {0, 0, -0.1, 0, 0, 0}, state).allowed[2], 0, 1e-4);
  EXPECT_NEAR(Guarded(lab, {0, 0, 0.1, 0, 0, 0}, state).allowed[2], 0.1, 1e-3);
  EXPECT_NEAR(Guarded(lab, {0.1, 0, -0.1, 0, 0, 0}, state).allowed[0], 0.1, 1e-3);
  EXPECT_EQ(Guarded(lab, {0, 0, -0.1, 0, 0, 0}, state).active.bound, Bound::kForce);
  state.O_F_ext_hat_K[2] = -30;
  EXPECT_NEAR(Guarded(lab, {0, 0, -0.1, 0, 0, 0}, state).allowed[2],
              -MotionGuard::kDecay * 10 / MotionGuard::kStiffest, 1e-4);
  state.O_F_ext_hat_K[2] = -19;
  EXPECT_NEAR(Guarded(lab, {0, 0, -0.1, 0, 0, 0}, state).allowed[2], -0.1, 1e-3);
}

TEST(LedLimitsGuardTest, StopsAJointThatPushesAtItsCapOnTorque) {
  const model::LabLimits lab{.tau_max = JointVector{10, 10, 10, 10, 10, 10, 10}};
  RobotState state;
  state.tau_ext_hat_filtered[0] = 10;  // joint 1 pushes to the left, along y
  const Guarded further(lab, {0, 0.1, 0, 0, 0, 0}, state);
  EXPECT_EQ(further.active, (ActiveBound{Bound::kTorque, 1}));
  EXPECT_NEAR(Guarded(lab, {0, -0.1, 0, 0, 0, 0}, state).allowed[1], -0.1, 1e-3);
}

TEST(LedLimitsGuardTest, NoJointTurnsFasterThanItsCap) {
  JointVector cap;
  cap.fill(0.1);
  const Guarded guarded({.dq_max = cap}, {0, 0.25, 0, 0, 0, 0});
  const model::Jacobian J =
      model::ArmModel::Panda().ZeroJacobian(model::Frame::kEndEffector, kReady);
  // Straight to the side, joint 1 does what it can at its radius, and others a little of it.
  EXPECT_LT(guarded.allowed[1], 0.25);
  EXPECT_GT(guarded.allowed[1], 0.5 * MotionGuard::kCapShare * 0.1 * J[1]);
  EXPECT_EQ(guarded.active.bound, Bound::kJointSpeed);
}

}  // namespace
}  // namespace twin::teleop::teleop_limits_test

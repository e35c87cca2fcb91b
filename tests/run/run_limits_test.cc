// Motions against the limits of a lab and of the end effector: refused, or planned within them.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "controllers/registration.h"
#include "plugins/backends.h"
#include "twin/model/arm_model.h"
#include "twin/model/lab_limits.h"
#include "twin/run/run.h"

namespace twin::run::run_limits_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Joint 1 turns by kTurn rad in kTime s, by a quintic: its peak speed is 15/8 kTurn / kTime.
constexpr double kTurn = 0.5;
constexpr double kTime = 2;
constexpr double kPeak = 15.0 / 8 * kTurn / kTime;

std::string TrajectoryText() {
  return fmt::format(R"(motion:
  trajectory:
    unit: rad
    waypoints:
      - {{q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 0 s}}
      - {{q: [{}, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: {} s}}
)",
                     kTurn, kTime);
}

class RunLimitsTest : public ::testing::Test {
 protected:
  RunLimitsTest() {
    plugins::RegisterMujoco(backends_);
    controllers::RegisterControllers(controllers_);
  }

  [[nodiscard]] reference::Trajectory Prepare(const std::string& limits,
                                              const std::string& motion = TrajectoryText()) const {
    const scenario::Scenario scenario = scenario::Parse(
        "name: limited\nplant: {kind: ideal}\n" + motion + "limits: " + limits + "\n", "s.yaml");
    const run::Run run(scenario, {backends_, controllers_, nullptr},
                       {.models = std::filesystem::path(TWIN_SOURCE_DIR) / "models",
                        .mesh_package = {},
                        .cache = {}},
                       nullptr);
    return run.trajectory();
  }
  [[nodiscard]] std::string Refusal(const std::string& limits,
                                    const std::string& motion = TrajectoryText()) const {
    try {
      (void)Prepare(limits, motion);
    } catch (const InputError& breach) {
      return breach.what();
    }
    return "accepted";
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
};

std::string Wall(double offset) {
  return fmt::format(
      "{{regions: [{{name: wall, what: [end_effector], keep: inside, half_space: "
      "{{normal: [0, 1, 0], offset: {} m}}}}]}}",
      offset);
}

/// The end effector's distance from the axis of joint 1, m.
double Radius() {
  const Transform O_T_F = model::ArmModel::Panda().Pose(
      model::Frame::kFlange, JointVector{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854});
  return std::hypot(O_T_F[12] + 0.1034 * O_T_F[8], O_T_F[13] + 0.1034 * O_T_F[9]);
}

TEST_F(RunLimitsTest, ATrajectoryThatLeavesItsRegionIsRefusedWithPlaceAndTime) {
  const double reached = Radius() * std::sin(kTurn);
  EXPECT_EQ(Refusal(Wall(reached + 0.001)), "accepted");
  EXPECT_THAT(Refusal(Wall(reached - 0.001)),
              AllOf(HasSubstr("motion: at 1."), HasSubstr("s of 2.000 s, joints at [0.4"),
                    HasSubstr("limit \"wall\": the end effector reaches y = "),
                    HasSubstr(fmt::format("m; it must be at most {:.5f} m", reached - 0.001))));
}

TEST_F(RunLimitsTest, AStartOutsideIsRefused) {
  EXPECT_THAT(Refusal(Wall(-0.05)),
              AllOf(HasSubstr("motion: at its start"), HasSubstr("0.00000 m; it must be at most "
                                                                 "-0.05000 m")));
}

TEST_F(RunLimitsTest, AMotionFasterThanACapIsRefused) {
  const auto joints = [](double cap) {
    return fmt::format("{{speed: {{joints: {} rad/s}}}}", cap);
  };
  EXPECT_EQ(Refusal(joints(1.001 * kPeak)), "accepted");
  EXPECT_THAT(Refusal(joints(0.999 * kPeak)),
              AllOf(HasSubstr("limit speed.joints: joint 1 moves at"),
                    HasSubstr("give the motion more time")));
  const auto hand = [](double cap) {
    return fmt::format("{{speed: {{end_effector: {} m/s}}}}", cap);
  };
  EXPECT_EQ(Refusal(hand(1.001 * kPeak * Radius())), "accepted");
  EXPECT_THAT(Refusal(hand(0.999 * kPeak * Radius())), HasSubstr("speed.end_effector"));
  EXPECT_THAT(Refusal(fmt::format("{{speed: {{rotation: {} rad/s}}}}", 0.999 * kPeak)),
              HasSubstr("speed.rotation"));
}

TEST_F(RunLimitsTest, PosesAreJudgedByEndEffectorAndHand) {
  const std::string motion = R"(controller: {type: cartesian_pose}
motion:
  poses:
    start: {unit: rad, values: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
    waypoints: [{by: [0 m, 0.1 m, 0 m]}]
)";
  EXPECT_EQ(Refusal(Wall(0.11), motion), "accepted");
  EXPECT_THAT(Refusal(Wall(0.09), motion),
              HasSubstr("limit \"wall\": the end effector reaches y = 0.09"));
}

TEST_F(RunLimitsTest, APlanGoesAroundARegionAndKeepsTheCaps) {
  const std::string motion =
      R"(robot: {q_start: {unit: rad, values: [-0.8, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}}
motion:
  plan: {goal: {q: {unit: rad, values: [0.8, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}}}
)";
  const model::LabLimits limits{.regions = {{"pillar",
                                             {model::LimitedPart::kEndEffector},
                                             false,
                                             model::LimitBox{{0.2, -0.1, 0.3}, {0.5, 0.1, 0.6}}}}};
  const Transform F_T_EE{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.1034, 1};
  const auto least = [&](const reference::Trajectory& trajectory) {
    double margin = 1;
    for (Duration t{}; t <= trajectory.duration(); t += kCycle) {
      const auto one = model::LeastMargin(limits, {F_T_EE, true}, trajectory.Sample(t).q);
      margin = std::min(margin, one.value().margin);
    }
    return margin;
  };
  EXPECT_LT(least(Prepare("{}", motion)), 0);  // straight through
  const reference::Trajectory around = Prepare(
      "{regions: [{name: pillar, what: [end_effector], keep: outside, box: {min: [0.2 m, -0.1 m, "
      "0.3 m], max: [0.5 m, 0.1 m, 0.6 m]}}], speed: {joints: 0.5 rad/s, end_effector: 0.1 m/s}}",
      motion);
  EXPECT_GT(least(around), 0);
  for (Duration t{}; t <= around.duration(); t += kCycle) {
    const reference::JointTarget target = around.Sample(t);
    for (const double dq : target.dq) EXPECT_LE(std::abs(dq), 0.5);
    EXPECT_LE(HalfNorm(model::ArmModel::Panda().Twist(model::Frame::kEndEffector, target.q,
                                                      target.dq, F_T_EE),
                       0),
              0.1);
  }
}

TEST_F(RunLimitsTest, AMotionThatIsTooFastNearTheEndOfARangeIsRefused) {
  // Nearly to the end of the range: fast enough for the middle of the range.
  const auto text = [](const char* model, double time) {
    return fmt::format(R"(robot: {{model: {}}}
motion:
  trajectory:
    unit: rad
    waypoints:
      - {{q: [2.0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: 0 s}}
      - {{q: [2.74, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854], at: {} s}}
)",
                       model, time);
  };
  EXPECT_THAT(Refusal("{}", text("fr3", 0.75)),
              AllOf(HasSubstr("motion: at 0."), HasSubstr("joint 1 moves at"),
                    HasSubstr("the robot permits 1.8"), HasSubstr("give the motion more time")));
  EXPECT_NO_THROW((void)Prepare("{}", text("fr3", 2)));
  EXPECT_NO_THROW((void)Prepare("{}", R"(robot: {model: fr3}
motion:
  trajectory:
    unit: rad
    velocity_scale: 1
    acceleration_scale: 1
    jerk_scale: 1
    waypoints:
      - {q: [2.0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [2.72, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
)")) << "a motion without times takes its time";
  EXPECT_NO_THROW((void)Prepare("{}", text("panda", 0.75)));
}

/// A wrist that turns fast: joints 4 and 6 by almost 0.4 rad, from rest to rest.
std::string TurningText(const std::string& pace, const std::string& interface = "cartesian_pose") {
  return fmt::format(R"(motion:
  interface: {}
  trajectory:
    unit: rad
    {}
    waypoints:
      - {{q: [0.076, -0.756, 0.036, -2.470, 0.197, 1.294, 0.984]}}
      - {{q: [0.058, -0.883, -0.132, -2.148, 0.261, 1.646, 1.082]}}
)",
                     interface, pace);
}

// Campaign, world 426851: the robot would abort such a motion.
TEST_F(RunLimitsTest, RefusesPosesThatTheEndEffectorCannotFollow) {
  EXPECT_THAT(Refusal("{}", TurningText("duration: 0.5 s")),
              AllOf(HasSubstr("the end effector turns at a speed of"), HasSubstr("limit is 2.5"),
                    HasSubstr("admissible from 0.63")));
  EXPECT_EQ(Prepare("{}", TurningText("duration: 0.64 s")).duration(), FromSeconds(0.64));
  EXPECT_EQ(Prepare("{}", TurningText("duration: 0.5 s", "joint_position")).duration(),
            FromSeconds(0.5))
      << "the robot does not limit the end effector on commands to the joints";
}

TEST_F(RunLimitsTest, GivesPosesTheTimeThatTheEndEffectorNeeds) {
  const std::string pace = "acceleration_scale: 0.8";
  const Duration joints = Prepare("{}", TurningText(pace, "joint_position")).duration();
  const reference::Trajectory poses = Prepare("{}", TurningText(pace));
  EXPECT_GT(poses.duration(), joints);
  double fastest = 0;
  for (Duration t{}; t < poses.duration(); t += kCycle) {
    const reference::JointTarget target = poses.Sample(t);
    fastest = std::max(
        fastest,
        HalfNorm(model::ArmModel::Panda().Twist(model::Frame::kFlange, target.q, target.dq), 3));
  }
  EXPECT_NEAR(fastest, 0.5 * 2.5, 1e-3) << "half the limit, as velocity_scale says by default";
}

}  // namespace
}  // namespace twin::run::run_limits_test

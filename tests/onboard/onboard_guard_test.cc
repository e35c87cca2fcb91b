#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error_catalogue.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/onboard_controller.h"

namespace twin::onboard::onboard_guard_test {
namespace {

using enum MotionGeneratorMode;
using enum ControllerMode;

constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
constexpr double kWall = 0.1;  // m along y

/// The end effector stays on this side of a wall at y = kWall; at the ready pose it has y = 0.
model::LabLimits Wall() {
  model::LabLimits limits;
  limits.regions.push_back({.name = "wall",
                            .parts = {model::LimitedPart::kEndEffector},
                            .shape = model::HalfSpace{{0, 1, 0}, kWall}});
  return limits;
}

double YOf(const JointVector& q) {
  return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q)[13];
}

/// INT on a body that does what is desired.
class Guarded {
 public:
  explicit Guarded(const model::LabLimits& limits) : onboard_(Config(limits), kReady) {}

  void Start(const MotionModes& modes) {
    Cycle(nullptr);
    ASSERT_EQ(onboard_.Move(modes), MoveStatus::kMotionStarted);
    Cycle(nullptr);
    Cycle(nullptr);
  }
  void Cycle(const RobotCommand* command) {
    const JointDrive& drive = onboard_.Cycle(command, sensors_);
    sensors_.q = drive.q_d;
    sensors_.dq = drive.dq_d;
    sensors_.tau_J = drive.tau;
    onboard_.FillState(sensors_, state_);
    farthest_ = std::max(farthest_, YOf(state_.q_d));
  }
  /// Cycles until INT has stopped the arm, or 2000. @param lost  whether a cycle's command is lost.
  template <typename Command, typename Lost>
  void Drive(const Command& make, const Lost& lost) {
    for (std::uint32_t cycle = 0; cycle < 2000; ++cycle) {
      RobotCommand command = make(cycle);
      command.message_id = state_.message_id;
      Cycle(lost(cycle) ? nullptr : &command);
      if (state_.robot_mode == RobotMode::kReflex && onboard_.reference().AtRest()) return;
    }
  }
  [[nodiscard]] bool Reports(RobotError error) const {
    return state_.errors.test(static_cast<std::size_t>(error));
  }
  [[nodiscard]] const OnboardController& onboard() const { return onboard_; }
  [[nodiscard]] const RobotState& state() const { return state_; }
  [[nodiscard]] double farthest() const { return farthest_; }

 private:
  static OnboardConfig Config(const model::LabLimits& limits) {
    OnboardConfig config;
    config.limits = test::PandaLimits();
    config.cartesian = test::PandaCartesianLimits();
    config.guard = limits;
    return config;
  }

  OnboardController onboard_;
  JointSensors sensors_{kReady, {}, {}, kReady, {}};
  RobotState state_;
  double farthest_ = -1;
};

/// Turns joint 1 faster and faster, at 5 rad/s^2 up to 2 rad/s: towards the wall.
RobotCommand TurnOn(std::uint32_t cycle) {
  RobotCommand command;
  command.dq_c[0] = std::min(5e-3 * (cycle + 1), 2.0);
  return command;
}
/// Moves the hand along y, at 1 m/s^2 up to 0.5 m/s.
RobotCommand MoveOn(std::uint32_t cycle) {
  RobotCommand command;
  command.O_dP_EE_c[1] = std::min(1e-3 * (cycle + 1), 0.5);
  return command;
}
constexpr auto kNoneLost = [](std::uint32_t) { return false; };

void ExpectStoppedAtWall(const Guarded& robot) {
  EXPECT_EQ(robot.state().robot_mode, RobotMode::kReflex);
  EXPECT_EQ(robot.onboard().last_end(), MoveStatus::kReflexAborted);
  EXPECT_TRUE(robot.Reports(RobotError::kCartesianPositionLimitsViolation));
  EXPECT_EQ(robot.state().errors.count(), 1U);
  EXPECT_LE(robot.farthest(), kWall);
  EXPECT_GT(robot.farthest(), kWall - 0.01);
  ASSERT_TRUE(robot.onboard().guard_breach());
  EXPECT_EQ(Describe(Wall(), *robot.onboard().guard_breach()).rfind("limit \"wall\"", 0), 0U);
  EXPECT_GT(robot.onboard().guard_breach()->value, kWall);
  EXPECT_EQ(robot.onboard().guard_breach()->bound, kWall);
}

TEST(GuardTest, AJointStreamStopsBeforeTheWall) {
  Guarded robot(Wall());
  robot.Start({kJointImpedance, kJointVelocity});
  robot.Drive(TurnOn, kNoneLost);
  ExpectStoppedAtWall(robot);
}

TEST(GuardTest, ACartesianStreamStopsBeforeTheWall) {
  Guarded robot(Wall());
  robot.Start({kJointImpedance, kCartesianVelocity});
  robot.Drive(MoveOn, kNoneLost);
  ExpectStoppedAtWall(robot);
}

TEST(GuardTest, WithoutAGuardTheSameStreamsPassTheWall) {
  Guarded joints({});
  joints.Start({kJointImpedance, kJointVelocity});
  joints.Drive(TurnOn, kNoneLost);
  EXPECT_GT(joints.farthest(), kWall);
  Guarded hand({});
  hand.Start({kJointImpedance, kCartesianVelocity});
  hand.Drive(MoveOn, kNoneLost);
  EXPECT_GT(hand.farthest(), kWall);
}

TEST(GuardTest, LostCommandsDoNotLeadThroughTheWall) {
  // Bursts of up to 15 at random times; without 20 in a row, only the guard ends the motion.
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Random random(seed, RandomStream::kTest);
    const auto lost = [&random](std::uint32_t cycle) {
      const std::uint32_t burst = cycle / 20;
      return cycle > 0 && cycle % 20 < 15 * random.Uniform(burst, 0);
    };
    // After a burst the command goes on from the acceleration that was held.
    Guarded robot(Wall());
    robot.Start({kJointImpedance, kJointVelocity});
    robot.Drive(
        [&robot](std::uint32_t) {
          RobotCommand command;
          command.dq_c[0] = robot.state().dq_d[0] + 5e-3;
          return command;
        },
        lost);
    ExpectStoppedAtWall(robot);
  }
}

TEST(GuardTest, ASpeedAboveItsCapIsTheErrorOfASpeed) {
  model::LabLimits limits;
  limits.dq_max.emplace().fill(0.5);
  Guarded joint(limits);
  joint.Start({kJointImpedance, kJointVelocity});
  joint.Drive(TurnOn, kNoneLost);
  EXPECT_TRUE(joint.Reports(RobotError::kJointVelocityViolation));
  const auto violation = joint.onboard().guard_breach();
  ASSERT_TRUE(violation);
  EXPECT_NEAR(violation->value, 0.505, 1e-9);  // the next step of 5e-3
  EXPECT_EQ(violation->bound, 0.5);

  limits = {};
  limits.v_max = 0.2;
  Guarded hand(limits);
  hand.Start({kJointImpedance, kCartesianVelocity});
  hand.Drive(MoveOn, kNoneLost);
  EXPECT_TRUE(hand.Reports(RobotError::kCartesianVelocityViolation));
}

TEST(GuardTest, TorquesThatDriveTheArmToTheWallEndInAStop) {
  // The body follows the reference here: its velocity stands for what torques did.
  model::LabLimits limits = Wall();
  Guarded robot(limits);
  robot.Start({kExternalController, kJointVelocity});
  robot.Drive(TurnOn, kNoneLost);
  EXPECT_TRUE(robot.Reports(RobotError::kCartesianPositionLimitsViolation));
  EXPECT_LT(robot.farthest(), kWall + 1e-3);  // a prediction, no proof
}

TEST(GuardTest, AClientMayGoOnAfterRecovery) {
  Guarded robot(Wall());
  robot.Start({kJointImpedance, kJointVelocity});
  robot.Drive(TurnOn, kNoneLost);
  OnboardController onboard = robot.onboard();
  EXPECT_EQ(onboard.AutomaticErrorRecovery(), RecoveryStatus::kSuccess);
}

TEST(GuardTest, AllocatesNothing) {
  Guarded robot(Wall());
  robot.Start({kJointImpedance, kJointVelocity});
  const test::RealtimeGuard guard;
  robot.Drive(TurnOn, kNoneLost);
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts());
}

}  // namespace
}  // namespace twin::onboard::onboard_guard_test

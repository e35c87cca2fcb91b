// What INT does for an FR3 alone: torque without a motion generator, goals of asynchronous motions,
// velocity limits that depend on the position, accelerometers.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "model/model_samples.h"
#include "support/fr3_limits.h"
#include "support/panda_limits.h"
#include "twin/core/time.h"
#include "twin/onboard/accelerometers.h"
#include "twin/onboard/goal_approach.h"
#include "twin/onboard/limit_monitor.h"
#include "twin/onboard/onboard_controller.h"

namespace twin::onboard::onboard_fr3_test {
namespace {

using test::Fr3Limits;

OnboardConfig Config() {
  OnboardConfig config;
  config.limits = config.own_limits.emplace(Fr3Limits());
  // For the rounding of a client's positions, which INT's own motions do not use.
  for (double& ddq : config.limits.ddq_max) ddq += 0.24;
  for (double& dddq : config.limits.dddq_max) dddq += 240;
  config.cartesian = test::PandaCartesianLimits();
  config.has_accelerometers = true;
  return config;
}

/// INT with an arm that follows its reference exactly.
class Fr3Test : public ::testing::Test {
 protected:
  void Cycle(const RobotCommand* command) {
    const JointDrive& drive = int_.Cycle(command, sensors_);
    sensors_.q = drive.q_d;
    sensors_.dq = drive.dq_d;
    sensors_.theta = drive.q_d;
    sensors_.dtheta = drive.dq_d;
    sensors_.tau_J =
        model::ArmModel::Panda().InverseDynamics(drive.q_d, drive.dq_d, drive.ddq_d, {});
    int_.FillState(sensors_, state_);
  }
  void Start(const MotionModes& modes) {
    ASSERT_EQ(int_.Move(modes), MoveStatus::kMotionStarted);
    Cycle(nullptr);
  }
  RobotCommand Answer() const {
    RobotCommand command;
    command.message_id = state_.message_id;
    return command;
  }

  OnboardController int_{Config(), model::kReady};
  JointSensors sensors_{.q = model::kReady, .theta = model::kReady};
  RobotState state_;
};

MotionModes Asynchronous(double dq_most) {
  JointVector most;
  most.fill(dq_most);
  return {ControllerMode::kJointImpedance, MotionGeneratorMode::kJointPosition, most};
}

TEST_F(Fr3Test, TorqueAloneKeepsTheReference) {
  Start({ControllerMode::kExternalController, MotionGeneratorMode::kNone});
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kNone);
  for (int k = 0; k < 50; ++k) {
    RobotCommand command = Answer();
    command.tau_J_d = state_.tau_J_d;
    command.tau_J_d[6] += 0.01;
    command.dq_c[0] = 5;  // means nothing without a generator
    Cycle(&command);
    ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
    EXPECT_EQ(state_.q_d, model::kReady);
  }
  RobotCommand last = Answer();
  last.tau_J_d = state_.tau_J_d;
  last.motion_generation_finished = true;
  Cycle(&last);
  for (int k = 0; k < 100 && state_.robot_mode == RobotMode::kMove; ++k) Cycle(nullptr);
  EXPECT_EQ(int_.last_end(), MoveStatus::kSuccess);
}

TEST_F(Fr3Test, RefusesModesThatDoNotExist) {
  const auto refused = [this](const MotionModes& modes) {
    return int_.Move(modes) == MoveStatus::kInvalidArgumentRejected;
  };
  EXPECT_TRUE(refused({ControllerMode::kJointImpedance, MotionGeneratorMode::kNone}));
  MotionModes modes = Asynchronous(1);
  modes.controller = ControllerMode::kExternalController;
  EXPECT_TRUE(refused(modes));
  modes = Asynchronous(1);
  modes.generator = MotionGeneratorMode::kJointVelocity;
  EXPECT_TRUE(refused(modes));
  for (const double most : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(refused(Asynchronous(most))) << most;
  }
}

TEST_F(Fr3Test, ApproachesEachGoalWithinAllLimitsAndEndsWhenAsked) {
  constexpr double kMost = 0.8;
  const JointLimits limits = Fr3Limits();
  Start(Asynchronous(kMost));
  for (int k = 0; k < 1500; ++k) Cycle(nullptr);  // a first goal has no deadline
  ASSERT_EQ(state_.robot_mode, RobotMode::kMove);

  JointVector goal = model::kReady;
  JointVector last_ddq{};
  for (const double way : {0.5, -0.3, 0.2}) {
    for (double& q : goal) q += way;
    goal[5] = std::max(goal[5], 0.6);
    RobotCommand command = Answer();
    command.q_c = goal;
    const int cycles = way == -0.3 ? 400 : 4000;  // the second goal is changed under way
    for (int k = 0; k < cycles; ++k) {
      Cycle(k == 0 ? &command : nullptr);
      ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
      for (std::size_t i = 0; i < kJoints; ++i) {
        ASSERT_LE(std::abs(state_.dq_d[i]), kMost * (1 + 1e-9));
        ASSERT_LE(std::abs(state_.ddq_d[i]), limits.ddq_max[i] * (1 + 1e-9));
        ASSERT_LE(std::abs(state_.ddq_d[i] - last_ddq[i]) / kCycleSeconds,
                  limits.dddq_max[i] * (1 + 1e-6));
      }
      last_ddq = state_.ddq_d;
    }
  }
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(state_.q_d[i], goal[i], 1e-4);

  RobotCommand end = Answer();  // its positions, zero, are no goal
  end.motion_generation_finished = true;
  Cycle(&end);
  for (int k = 0; k < 200 && state_.robot_mode == RobotMode::kMove; ++k) Cycle(nullptr);
  EXPECT_EQ(int_.last_end(), MoveStatus::kSuccess);
}

TEST_F(Fr3Test, RefusesAGoalOutsideTheRange) {
  Start(Asynchronous(1));
  RobotCommand command = Answer();
  command.q_c = model::kReady;
  command.q_c[3] = 0.5;
  Cycle(&command);
  EXPECT_TRUE(state_.errors[static_cast<std::size_t>(
      RobotError::kJointMotionGeneratorPositionLimitsViolation)]);
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
}

TEST(VelocityByPositionTest, IsThatOfTheStateThatTheCommandAnswers) {
  const JointLimits limits = Fr3Limits();
  JointReference reference = JointReference::Rest(model::kReady);
  reference.q_d[0] = limits.q_max[0] - 0.12;  // sqrt(12 0.12) - 0.3 = 0.9
  const auto violates = [&](double dq) {
    JointReference next = reference;
    next.dq_d[0] = dq;
    next.q_d[0] += dq * kCycleSeconds;
    return !CheckStep(next, limits, 1).empty();
  };
  EXPECT_FALSE(violates(0.8999999));
  EXPECT_TRUE(violates(0.9000001));
  EXPECT_FALSE(violates(-2)) << "away from the end the whole velocity is allowed";
  const Violations found = [&] {
    JointReference next = reference;
    next.dq_d[0] = 1;
    next.q_d[0] += kCycleSeconds;
    return CheckStep(next, limits, 1);
  }();
  ASSERT_EQ(found.items().size(), 1u);
  EXPECT_NEAR(found.items()[0].limit, 0.9, 1e-9);
}

TEST(VelocityByPositionTest, NeverReachesTheEndOfTheRange) {
  const JointLimits limits = Fr3Limits();
  JointReference reference = JointReference::Rest(model::kReady);
  const JointVector most = limits.dq_max;
  JointVector goal = limits.q_max;
  for (int k = 0; k < 20'000; ++k) {
    reference = ApproachStep(reference, goal, most, limits);
    ASSERT_TRUE(CheckStep(reference, limits, 1).empty()) << k;
  }
}

TEST(AccelerometersTest, ShowGravityAtRestInTheirAxes) {
  Accelerometers sensors;
  sensors.Update(model::ArmModel::Panda(), model::kReady, {});
  // Link 0 does not move; its upper sensor is turned over.
  EXPECT_NEAR(sensors.top()[2], -9.81, 1e-12);
  EXPECT_NEAR(sensors.bottom()[2], 9.81, 1e-12);
  for (std::size_t link = 0; link < 6; ++link) {
    const double* a = &sensors.top()[3 * link];
    EXPECT_NEAR(std::hypot(a[0], a[1], a[2]), 9.81, 1e-9);
  }
}

TEST(AccelerometersTest, ShowTheCentripetalAccelerationOfATurn) {
  // Joint 1 turns; link 3's sensor is 0.05 m and more from the axis.
  JointVector q = model::kReady;
  JointVector dq{};
  dq[0] = 2;
  Accelerometers sensors;
  for (int k = 0; k < 3; ++k) {
    sensors.Update(model::ArmModel::Panda(), q, dq);
    q[0] += dq[0] * kCycleSeconds;
  }
  const Transform O_T_3 = model::ArmModel::Panda().Pose(model::Frame::kJoint3, q);
  const Vector3 place{0.0825, 0.05, 0};
  Vector3 p{O_T_3[12], O_T_3[13], O_T_3[14]};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) p[r] += O_T_3[4 * c + r] * place[c];
  }
  const double radial = dq[0] * dq[0] * std::hypot(p[0], p[1]);
  const double* a = &sensors.top()[9];
  EXPECT_NEAR(std::hypot(a[0], a[1], a[2]), std::hypot(9.81, radial), 0.01);
}

}  // namespace
}  // namespace twin::onboard::onboard_fr3_test

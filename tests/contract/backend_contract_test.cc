// What every backend promises, whatever is behind it (include/twin/backend/backend.h).

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "contract/backend_harness.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::backend {
namespace {

constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};
constexpr MotionModes kVelocity{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointVelocity};

class BackendContractTest : public ::testing::TestWithParam<test::HarnessCase> {
 protected:
  void SetUp() override { harness_ = GetParam().make(); }

  Backend& backend() { return harness_->backend(); }

  const RobotState& Await() {
    EXPECT_TRUE(harness_->AwaitState(state_));
    return state_;
  }
  void AwaitMode(RobotMode mode) {
    for (int i = 0; i < 2000; ++i) {
      if (Await().robot_mode == mode) return;
    }
    FAIL() << "mode " << Name(mode) << " was never reached; it is " << Name(state_.robot_mode);
  }
  /// Starts a motion and reads up to state B, the first that is answered.
  void StartMotion(const MotionModes& modes) {
    Await();
    backend().Start(modes);
    AwaitMode(RobotMode::kMove);
    Await();
  }
  void AnswerPosition(const JointVector& q_c, bool finished = false) {
    RobotCommand command;
    command.message_id = state_.message_id;
    command.q_c = q_c;
    command.motion_generation_finished = finished;
    backend().Write(command);
    Await();
  }
  void AnswerVelocity(const JointVector& dq_c) {
    RobotCommand command;
    command.message_id = state_.message_id;
    command.dq_c = dq_c;
    backend().Write(command);
    Await();
  }

  std::unique_ptr<test::BackendHarness> harness_;
  RobotState state_;
};

TEST_P(BackendContractTest, GivesStatesWithRisingIdsFromTheStart) {
  std::uint64_t last = 0;
  for (int i = 0; i < 20; ++i) {
    Await();
    EXPECT_GT(state_.message_id, last);
    last = state_.message_id;
  }
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
}

TEST_P(BackendContractTest, AReadNeverWaits) {
  Await();
  Time arrival{};
  EXPECT_EQ(backend().Read(ReadRule::kNewest, state_, arrival), ReadResult::kPending);
}

TEST_P(BackendContractTest, ReportsItself) {
  const Description description = backend().Describe();
  EXPECT_FALSE(description.name.empty());
  EXPECT_FALSE(description.robot.empty());
  EXPECT_EQ(description.last_end, MotionEnd::kNone);
}

TEST_P(BackendContractTest, ShowsAllModesOfAStartedMotionInOneState) {
  Await();
  backend().Start(kPosition);
  AwaitMode(RobotMode::kMove);
  EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kJointPosition);
  EXPECT_EQ(state_.controller_mode, ControllerMode::kJointImpedance);
  EXPECT_EQ(state_.dq_d, JointVector{});
}

TEST_P(BackendContractTest, TakesCommandsIntoTheReference) {
  StartMotion(kPosition);
  JointVector q_c = state_.q_d;
  for (int i = 0; i < 10; ++i) {
    q_c[6] += 1e-6;
    AnswerPosition(q_c);
  }
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_EQ(state_.q_d, q_c);
  EXPECT_EQ(state_.control_command_success_rate, 1);
}

TEST_P(BackendContractTest, EndsAFinishedMotionWithSuccess) {
  StartMotion(kPosition);
  const JointVector q_c = state_.q_d;
  AnswerPosition(q_c);
  for (int i = 0; i < 20 && state_.robot_mode == RobotMode::kMove; ++i) AnswerPosition(q_c, true);
  EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
  EXPECT_EQ(backend().Describe().last_end, MotionEnd::kSuccess);
}

TEST_P(BackendContractTest, AbortsOnADiscontinuityAndSaysWhy) {
  StartMotion(kPosition);
  JointVector q_c = state_.q_d;
  AnswerPosition(q_c);
  q_c[1] += 5e-6;  // 5000 rad/s^3, joint 2 may have 3750
  AnswerPosition(q_c);
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(FormatErrors(state_.reflex_reason),
            "[\"joint_motion_generator_acceleration_discontinuity\"]");
  const Description description = backend().Describe();
  EXPECT_EQ(description.last_end, MotionEnd::kAborted);
  EXPECT_EQ(description.last_errors, state_.reflex_reason);
  for (const Violation& violation : description.violations) {
    EXPECT_EQ(violation.axis, 1);
    EXPECT_NEAR(violation.value, 5000, 1e-3);
    EXPECT_EQ(violation.limit, 3750);
  }
}

TEST_P(BackendContractTest, BridgesNineteenLostCommandsAndAbortsOnTwenty) {
  StartMotion(kVelocity);
  JointVector dq{};
  for (int i = 0; i < 100; ++i) {
    dq[0] += 2e-3;  // 2 rad/s^2
    AnswerVelocity(dq);
  }
  for (int lost = 0; lost < 19; ++lost) Await();
  ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_NEAR(state_.dq_d[0], dq[0] + 19 * 2e-3, 1e-12);
  dq[0] = state_.dq_d[0] + 2e-3;
  AnswerVelocity(dq);
  ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
  for (int lost = 0; lost < 20; ++lost) Await();
  EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_EQ(FormatErrors(state_.reflex_reason), "[\"communication_constraints_violation\"]");
}

TEST_P(BackendContractTest, RecoversOnceTheArmRestsAndRunsTheNextMotion) {
  StartMotion(kVelocity);
  JointVector dq{};
  for (int i = 0; i < 100; ++i) {
    dq[0] += 2e-3;
    AnswerVelocity(dq);
  }
  for (int lost = 0; lost < 20; ++lost) Await();
  ASSERT_EQ(state_.robot_mode, RobotMode::kReflex);
  EXPECT_THROW(backend().Recover(), RobotFault);
  EXPECT_THROW(backend().Start(kPosition), RobotFault);
  while (state_.dq_d != JointVector{}) Await();
  Await();
  backend().Recover();
  AwaitMode(RobotMode::kIdle);
  EXPECT_TRUE(state_.errors.none());
  StartMotion(kPosition);
  AnswerPosition(state_.q_d);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
}

TEST_P(BackendContractTest, StopsARunningMotionAndReportsItPreempted) {
  StartMotion(kVelocity);
  JointVector dq{};
  for (int i = 0; i < 100; ++i) {
    dq[0] += 2e-3;
    AnswerVelocity(dq);
  }
  backend().Stop();
  AwaitMode(RobotMode::kIdle);
  EXPECT_EQ(backend().Describe().last_end, MotionEnd::kPreempted);
  EXPECT_EQ(state_.dq_d, JointVector{});
}

TEST_P(BackendContractTest, RefusesWhatItDoesNotOffer) {
  Await();
  EXPECT_THROW(backend().Start({ControllerMode::kJointImpedance, MotionGeneratorMode::kIdle}),
               RobotFault);
  JointImpedance impedance;
  impedance.K_theta.fill(-1);
  EXPECT_THROW(backend().Configure(impedance), InputError);
  StartMotion(kPosition);
  impedance.K_theta.fill(1000);
  EXPECT_THROW(backend().Configure(impedance), RobotFault);
}

TEST_P(BackendContractTest, FollowsAMovingReferenceWithTheArm) {
  StartMotion(kVelocity);
  JointVector dq{};
  for (int k = 1; k <= 1000; ++k) {
    dq[3] = 0.2 * (1 - std::cos(2e-3 * M_PI * k));
    AnswerVelocity(dq);
  }
  ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
  EXPECT_NEAR(state_.q_d[3] - test::kHarnessStart[3], 0.2, 1e-3);
  EXPECT_NEAR(state_.q[3], state_.q_d[3], 2e-3);
}

TEST_P(BackendContractTest, AllocatesNothingWhileAMotionRuns) {
  StartMotion(kPosition);
  const JointVector q_c = state_.q_d;
  AnswerPosition(q_c);
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    RobotCommand command;
    command.message_id = state_.message_id;
    command.q_c = q_c;
    backend().Write(command);
    if (!harness_->AwaitState(state_)) break;
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.locks, 0);
  EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
}

INSTANTIATE_TEST_SUITE_P(Mujoco, BackendContractTest,
                         ::testing::Values(test::MujocoHarness(), test::IdealPlantHarness()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace twin::backend

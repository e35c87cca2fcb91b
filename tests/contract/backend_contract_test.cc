// What every backend promises, whatever is behind it (include/twin/backend/backend.h).
//
// On the wall clock a machine that is busy elsewhere can make a state go unread or a command miss
// its cycle. A promise that broke when this happened, and when a witness saw this machine late, is
// therefore tried again (Undisturbed, NotCutOff); the others hold whatever the machine does.

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "contract/backend_harness.h"
#include "support/realtime_guard.h"
#include "support/undisturbed.h"
#include "twin/core/error.h"
#include "twin/core/robot_errors.h"

namespace twin::backend::backend_contract_test {
namespace {

constexpr MotionModes kPosition{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointPosition};
constexpr MotionModes kVelocity{ControllerMode::kJointImpedance,
                                MotionGeneratorMode::kJointVelocity};
constexpr MotionModes kTorque{ControllerMode::kExternalController,
                              MotionGeneratorMode::kJointVelocity};

/// From 0.6 rad/s, at most 15 rad/s^2.
constexpr std::int64_t kCyclesOfAStop = 40;

class BackendContractTest : public ::testing::TestWithParam<test::HarnessCase> {
 protected:
  void SetUp() override { MakeHarness(); }

  void MakeHarness() { harness_ = GetParam().make(test::HarnessRobot(GetParam().plant_kind)); }

  Backend& backend() { return harness_->backend(); }

  const RobotState& Await(ReadRule rule = ReadRule::kNewest) {
    EXPECT_TRUE(harness_->AwaitState(state_, rule));
    return state_;
  }
  /// By the next state.
  bool IsAtRest() { return Await().dq_d == JointVector{}; }
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
    if (state_.robot_mode == RobotMode::kMove) harness_->ForgetDisturbances();
  }
  void Answer(RobotCommand command) {
    command.message_id = state_.message_id;
    backend().Write(command);
    Await();
  }
  void AnswerPosition(const JointVector& q_c, bool finished = false) {
    RobotCommand command;
    command.q_c = q_c;
    command.motion_generation_finished = finished;
    Answer(command);
  }
  void AnswerVelocity(const JointVector& dq_c) {
    RobotCommand command;
    command.dq_c = dq_c;
    Answer(command);
  }
  /// Joint 1 at 2 rad/s^2 from what it does now, for `states` states. A lost command changes
  /// nothing: the robot holds that acceleration.
  void SpeedUp(int states) {
    for (int i = 0; i < states; ++i) AnswerVelocity(Faster());
  }
  /// Breaks a velocity motion: by silence, or where that is waited for, by a step.
  void Break() {
    if (GetParam().waits_for_answers) {
      JointVector dq = Faster();
      dq[0] += 0.5;
      AnswerVelocity(dq);
    }
    AwaitMode(RobotMode::kReflex);
  }
  [[nodiscard]] JointVector Faster() const {
    JointVector dq = state_.dq_d;
    dq[0] += 2e-3;
    return dq;
  }

  /// For promises about consecutive cycles.
  void Undisturbed(const std::function<void()>& attempt) {
    Unspoilt(attempt,
             [this] { return harness_->disturbed() ? test::kAnyLoss : test::kNothingExcuses; });
  }
  /// For promises about a motion that bears the loss of some commands, but not of all for 20 ms.
  void NotCutOff(const std::function<void()>& attempt) {
    Unspoilt(attempt, [this] {
      constexpr std::uint64_t kBorne = 19;  // and before its first command a motion counts no loss
      const auto lost = static_cast<std::size_t>(RobotError::kCommunicationConstraintsViolation);
      const bool cut_off = harness_->disturbed() && (harness_->missed_in_row() > kBorne ||
                                                     backend().Describe().last_errors.test(lost));
      return cut_off ? test::kEndsAMotion : test::kNothingExcuses;
    });
  }
  /// Runs `attempt` on a new harness until it holds, or fails though the machine was not as late
  /// as that needs: so many cycles in a row.
  void Unspoilt(const std::function<void()>& attempt, const std::function<std::int64_t()>& needed) {
    constexpr int kAttempts = 50;
    test::Undisturbed(
        [&] {
          harness_.reset();
          MakeHarness();
          attempt();
        },
        needed, test::ByWitness(GetParam().fifo_priority), kAttempts);
  }

  std::unique_ptr<test::BackendHarness> harness_;
  RobotState state_;
};

/// Of backends that lose a command that is not written.
class LosingBackendContractTest : public BackendContractTest {};

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
  // A state comes every millisecond; reads that never wait outrun them.
  Await();
  Time arrival{};
  int pending = 0;
  for (int i = 0; i < 1000; ++i) {
    const ReadResult result = backend().Read(ReadRule::kNewest, state_, arrival);
    pending += result == ReadResult::kPending ? 1 : 0;
  }
  EXPECT_GE(pending, 500);
}

TEST_P(BackendContractTest, ANewestReadGivesTheNewestOfWhatIsQueued) {
  const std::uint64_t before = Await().message_id;
  ASSERT_TRUE(harness_->AwaitArrivals(3));
  Time arrival{};
  ASSERT_EQ(backend().Read(ReadRule::kNewest, state_, arrival), ReadResult::kState);
  EXPECT_GE(state_.message_id, before + 3);
}

TEST_P(BackendContractTest, AFreshReadThrowsAwayWhatIsQueued) {
  const std::uint64_t before = Await().message_id;
  ASSERT_TRUE(harness_->AwaitArrivals(3));
  Time arrival{};
  EXPECT_EQ(backend().Read(ReadRule::kFresh, state_, arrival), ReadResult::kPending);
  EXPECT_EQ(state_.message_id, before) << "written without a state";
  EXPECT_GT(Await(ReadRule::kFresh).message_id, before + 3);
}

TEST_P(BackendContractTest, ReportsItself) {
  const Description description = backend().Describe();
  EXPECT_FALSE(description.name.empty());
  EXPECT_FALSE(description.robot.empty());
  EXPECT_EQ(description.last_end, MotionEnd::kNone);
}

TEST_P(BackendContractTest, ShowsAllModesOfAStartedMotionInOneState) {
  NotCutOff([this] {
    Await();
    backend().Start(kPosition);
    AwaitMode(RobotMode::kMove);
    EXPECT_EQ(state_.motion_generator_mode, MotionGeneratorMode::kJointPosition);
    EXPECT_EQ(state_.controller_mode, ControllerMode::kJointImpedance);
    EXPECT_EQ(state_.dq_d, JointVector{});
  });
}

TEST_P(BackendContractTest, TakesCommandsIntoTheReference) {
  Undisturbed([this] {
    StartMotion(kPosition);
    JointVector q_c = state_.q_d;
    for (int i = 0; i < 10; ++i) {
      q_c[6] += 1e-6;
      AnswerPosition(q_c);
    }
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
    EXPECT_EQ(state_.q_d, q_c);
    EXPECT_EQ(state_.control_command_success_rate, 1);
  });
}

TEST_P(BackendContractTest, TakesTorqueCommandsOfTheExternalController) {
  Undisturbed([this] {
    StartMotion(kTorque);
    EXPECT_EQ(state_.controller_mode, ControllerMode::kExternalController);
    RobotCommand command;
    command.tau_J_d = state_.tau_J_d;
    for (int i = 0; i < 10; ++i) {
      command.tau_J_d[6] += 0.01;
      Answer(command);
    }
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
    EXPECT_EQ(state_.tau_J_d, command.tau_J_d);
  });
}

TEST_P(LosingBackendContractTest, ATorqueLoopSurvivesOneLostCommandAndNotTwenty) {
  Undisturbed([this] {
    StartMotion(kTorque);
    RobotCommand command;
    command.tau_J_d = state_.tau_J_d;
    command.tau_J_d[6] += 0.1;
    Answer(command);
    Await();
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
    EXPECT_EQ(state_.tau_J_d, command.tau_J_d) << "the last torque is held";
    Answer(command);
    for (int lost = 0; lost < 19; ++lost) Await();
    ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
    Await();
    EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
    EXPECT_EQ(FormatErrors(state_.reflex_reason), "[\"communication_constraints_violation\"]");
  });
}

TEST_P(BackendContractTest, EndsAFinishedMotionWithSuccess) {
  NotCutOff([this] {
    StartMotion(kPosition);
    const JointVector q_c = state_.q_d;
    AnswerPosition(q_c);
    for (int i = 0; i < 1000 && state_.robot_mode == RobotMode::kMove; ++i) {
      AnswerPosition(q_c, true);
    }
    EXPECT_EQ(state_.robot_mode, RobotMode::kIdle);
    EXPECT_EQ(backend().Describe().last_end, MotionEnd::kSuccess);
  });
}

TEST_P(BackendContractTest, AbortsOnADiscontinuityAndSaysWhy) {
  Undisturbed([this] {
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
  });
}

TEST_P(LosingBackendContractTest, BridgesNineteenLostCommands) {
  Undisturbed([this] {
    StartMotion(kVelocity);
    SpeedUp(100);
    harness_->ForgetDisturbances();
    const JointVector last = Faster();
    AnswerVelocity(last);
    for (int lost = 0; lost < 19; ++lost) Await();
    ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
    EXPECT_NEAR(state_.dq_d[0], last[0] + 19 * 2e-3, 1e-12);
    SpeedUp(3);
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  });
}

TEST_P(LosingBackendContractTest, AbortsOnTwentyLostCommands) {
  Undisturbed([this] {
    StartMotion(kVelocity);
    SpeedUp(100);
    harness_->ForgetDisturbances();
    SpeedUp(1);
    for (int lost = 0; lost < 19; ++lost) Await();
    ASSERT_EQ(state_.robot_mode, RobotMode::kMove);
    Await();
    EXPECT_EQ(state_.robot_mode, RobotMode::kReflex);
    EXPECT_EQ(FormatErrors(state_.reflex_reason), "[\"communication_constraints_violation\"]");
  });
}

TEST_P(BackendContractTest, RefusesMotionsWhileTheArmStillMoves) {
  Unspoilt(
      [this] {
        StartMotion(kVelocity);
        SpeedUp(300);
        Break();
        EXPECT_THROW(backend().Start(kPosition), RobotFault);
        EXPECT_FALSE(IsAtRest()) << "nothing was refused for the arm's motion";
      },
      [this] { return IsAtRest() ? kCyclesOfAStop : test::kNothingExcuses; });
}

TEST_P(BackendContractTest, RecoversNoArmThatStillMoves) {
  bool was_at_rest = false;
  Unspoilt(
      [&] {
        StartMotion(kVelocity);
        SpeedUp(300);
        Break();
        was_at_rest = state_.dq_d == JointVector{};
        EXPECT_FALSE(was_at_rest);
        if (harness_->recovers_at_rest()) {
          backend().Recover();
          AwaitMode(RobotMode::kIdle);
          EXPECT_EQ(state_.dq_d, JointVector{});
          EXPECT_TRUE(state_.errors.none());
        } else {
          EXPECT_THROW(backend().Recover(), RobotFault);
          EXPECT_FALSE(IsAtRest()) << "nothing was refused for the arm's motion";
        }
      },
      [&] {
        const bool came_late = was_at_rest || (!harness_->recovers_at_rest() && IsAtRest());
        return came_late ? kCyclesOfAStop : test::kNothingExcuses;
      });
}

TEST_P(BackendContractTest, RecoversOnceTheArmRestsAndRunsTheNextMotion) {
  Undisturbed([this] {
    StartMotion(kVelocity);
    SpeedUp(100);
    Break();
    while (state_.dq_d != JointVector{}) Await();
    Await();
    backend().Recover();
    AwaitMode(RobotMode::kIdle);
    EXPECT_TRUE(state_.errors.none());
    StartMotion(kPosition);
    AnswerPosition(state_.q_d);
    EXPECT_EQ(state_.robot_mode, RobotMode::kMove);
  });
}

TEST_P(BackendContractTest, StopsARunningMotionAndReportsItPreempted) {
  NotCutOff([this] {
    StartMotion(kVelocity);
    SpeedUp(100);
    backend().Stop();
    AwaitMode(RobotMode::kIdle);
    EXPECT_EQ(backend().Describe().last_end, MotionEnd::kPreempted);
    EXPECT_EQ(state_.dq_d, JointVector{});
  });
}

TEST_P(BackendContractTest, RefusesWhatItDoesNotOffer) {
  NotCutOff([this] {
    Await();
    EXPECT_THROW(backend().Start({ControllerMode::kJointImpedance, MotionGeneratorMode::kIdle}),
                 RobotFault);
    setting::JointImpedance impedance;
    impedance.K_theta.fill(-1);
    EXPECT_THROW(backend().Configure(impedance), InputError);
    StartMotion(kPosition);
    impedance.K_theta.fill(1000);
    EXPECT_THROW(backend().Configure(impedance), RobotFault);
  });
}

TEST_P(BackendContractTest, FollowsAMovingReferenceWithTheArm) {
  NotCutOff([this] {
    StartMotion(kVelocity);
    const std::uint64_t first = state_.message_id;
    JointVector dq{};
    // By INT's time, so that a state that was not read does not stretch the motion; and so gentle
    // that a command up to 19 cycles late steps by less than the limit of jerk.
    for (std::uint64_t k = 0; k < 1000; k = state_.message_id - first) {
      dq[3] = 0.02 * (1 - std::cos(2e-3 * M_PI * static_cast<double>(k + 1)));
      AnswerVelocity(dq);
    }
    ASSERT_EQ(state_.robot_mode, RobotMode::kMove)
        << FormatErrors(backend().Describe().last_errors);
    EXPECT_NEAR(state_.q_d[3] - test::kHarnessStart[3], 0.02, 2e-4);
    EXPECT_NEAR(state_.q[3], state_.q_d[3], 1e-3);
  });
}

TEST_P(BackendContractTest, AllocatesNothingWhileAMotionRuns) {
  NotCutOff([this] {
    StartMotion(kPosition);
    const JointVector q_c = state_.q_d;
    AnswerPosition(q_c);
    const test::RealtimeGuard guard;
    int states = 0;
    for (; states < 1000; ++states) {
      RobotCommand command;
      command.message_id = state_.message_id;
      command.q_c = q_c;
      backend().Write(command);
      if (!harness_->AwaitState(state_, ReadRule::kFresh)) break;
    }
    const test::RealtimeGuard::Counts counts = guard.counts();
    EXPECT_EQ(counts.allocations, 0);
    EXPECT_EQ(counts.locks, 0);
    EXPECT_EQ(states, 1000);
  });
}

std::vector<test::HarnessCase> LosingHarnesses() {
  std::vector<test::HarnessCase> harnesses = test::Harnesses();
  std::erase_if(harnesses, [](const test::HarnessCase& one) { return one.waits_for_answers; });
  return harnesses;
}

INSTANTIATE_TEST_SUITE_P(Mujoco, LosingBackendContractTest, ::testing::ValuesIn(LosingHarnesses()),
                         [](const auto& info) { return info.param.name; });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LosingBackendContractTest);

INSTANTIATE_TEST_SUITE_P(Mujoco, BackendContractTest, ::testing::ValuesIn(test::Harnesses()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace twin::backend::backend_contract_test

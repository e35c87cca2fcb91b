// A robot in lockstep with a workstation beyond a port. Nothing here depends on how fast the
// threads run; where the test waits, it waits for what must come.

#include "twin/robot/answer_paced_robot.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "robot/answer_paced_fixture.h"
#include "robot/robot_fixture.h"
#include "twin/core/error.h"
#include "twin/fci/datagrams.h"
#include "twin/robot/robot_config.h"

namespace twin::robot::answer_paced {
namespace {

TEST_F(AnswerPacedRobotTest, StatesFlowWhileNobodyAnswers) {
  Make(Ideal());
  for (std::uint64_t id = 1; id <= 30; ++id) EXPECT_EQ(wire_->Next().message_id, id);
}

TEST_F(AnswerPacedRobotTest, EveryStateOfAMotionIsAnsweredBeforeTheNext) {
  Make(Ideal(), kFreeze);
  const std::vector<RobotState> states = Drive(Start());
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
  ASSERT_GT(states.size(), static_cast<std::size_t>(kMotionCycles));
  for (std::size_t i = 1; i < states.size(); ++i) {
    EXPECT_EQ(states[i].message_id, states[i - 1].message_id + 1);
  }
  for (std::size_t i = 0; i + 1 < states.size(); ++i) {
    EXPECT_DOUBLE_EQ(states[i].control_command_success_rate, 1);
  }
}

TEST_F(AnswerPacedRobotTest, HowLongAnAnswerTakesDoesNotMatter) {
  Make(Ideal(), kFreeze);
  const auto prompt = Contents(Drive(Start()));
  Make(Ideal(), kFreeze);
  const auto slow = Contents(Drive(Start(), [](int k) {
    if (k % 37 == 1) std::this_thread::sleep_for(milliseconds(4));
  }));
  EXPECT_EQ(prompt, slow);
}

TEST_F(AnswerPacedRobotTest, WithAPaceItIsNeverAheadOfTheWallClock) {
  const Time begin = clock_.Now();
  Make(Ideal(), {.pace = 0.5});
  const RobotState first = wire_->Next();
  const auto ahead = [&](const RobotState& state) {
    const auto cycles = static_cast<std::int64_t>(state.message_id - first.message_id);
    return 2 * cycles * kCycle - (clock_.Now() - begin);
  };
  RobotState state = Start();
  EXPECT_LT(ahead(state), 2 * kCycle);
  for (const RobotState& later : Drive(state)) state = later;
  EXPECT_LT(ahead(state), 2 * kCycle);
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
}

TEST_F(AnswerPacedRobotTest, APaceChangesNoState) {
  Make(Ideal(), kFreeze);
  const auto unbounded = Contents(Drive(Start()));
  Make(Ideal(), {.freeze_when_idle = true, .pace = 2});
  EXPECT_EQ(Contents(Drive(Start())), unbounded);
}

TEST_F(AnswerPacedRobotTest, RefusesAPaceOutOfRange) {
  EXPECT_THROW(Make(Ideal(), {.pace = 0}), InputError);
  EXPECT_THROW(Make(Ideal(), {.pace = 101}), InputError);
}

TEST_F(AnswerPacedRobotTest, AnAnswerToAnotherStateIsNone) {
  Make(Ideal(), kFreeze);
  const RobotState state = After(Stand().message_id);
  RobotCommand command;
  command.q_c = state.q_d;
  const auto answer = [&](std::uint64_t id) {
    command.message_id = id;
    wire_->Answer(command);
  };
  for (const auto id : {state.message_id - 1, state.message_id + 1, 0UL, ~0UL}) answer(id);
  EXPECT_EQ(wire_->Next().message_id, state.message_id);  // the same again, and again
  EXPECT_EQ(wire_->Next().message_id, state.message_id);
  answer(state.message_id);
  EXPECT_EQ(After(state.message_id).message_id, state.message_id + 1);
}

TEST_F(AnswerPacedRobotTest, OnlyTheFirstAnswerToAStateCounts) {
  Make(Ideal(), kFreeze);
  RobotState state = Newest(Start());
  RobotCommand command;
  command.q_c = state.q_d;
  for (int i = 0; i < 100; ++i) {
    command.message_id = state.message_id;
    RobotCommand far = command;
    far.q_c[0] += 1;
    wire_->Answer({command, far});
    state = After(state.message_id);
    ASSERT_EQ(state.robot_mode, RobotMode::kMove) << FormatErrors(state.reflex_reason);
  }
  EXPECT_EQ(state.q_d, command.q_c);
}

TEST_F(AnswerPacedRobotTest, AMotionThatIsNotAnsweredIsStopped) {
  Make(Ideal(), {.answer_timeout = milliseconds(50), .freeze_when_idle = true});
  RobotState state = Stand();
  while (state.motion_generator_mode != MotionGeneratorMode::kIdle) state = wire_->Next();
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kPreempted);
  EXPECT_EQ(robot_->motions_given_up(), 1u);
  EXPECT_GT(wire_->Next().message_id, state.message_id);  // time goes on
  EXPECT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
}

TEST_F(AnswerPacedRobotTest, AnAsynchronousMotionWaitsForNobody) {
  Make(Ideal(), {.answer_timeout = milliseconds(50), .freeze_when_idle = true});
  MotionModes modes;
  modes.asynchronous.emplace().fill(1);
  ASSERT_EQ(robot_->Move(modes), MoveStatus::kMotionStarted);
  RobotState state = wire_->Next();
  while (state.motion_generator_mode == MotionGeneratorMode::kIdle) state = wire_->Next();
  RobotCommand goal;
  goal.message_id = state.message_id;
  goal.q_c = state.q_d;
  goal.q_c[0] += 0.02;
  static_cast<void>(After(state.message_id + 100));  // of a state long ago
  wire_->Answer(goal);
  for (int k = 0; k < 5000 && std::abs(state.q_d[0] - goal.q_c[0]) > 1e-3; ++k) {
    state = wire_->Next();
  }
  EXPECT_NEAR(state.q_d[0], goal.q_c[0], 1e-3);
  EXPECT_EQ(robot_->motions_given_up(), 0u);
  goal.motion_generation_finished = true;
  wire_->Answer(goal);
  while (state.motion_generator_mode != MotionGeneratorMode::kIdle) state = wire_->Next();
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
}

TEST_F(AnswerPacedRobotTest, AMotionThatWaitsForAnAnswerCanBeStopped) {
  Make(Ideal());
  RobotState state = After(Stand().message_id);
  robot_->StopMove();
  while (state.motion_generator_mode != MotionGeneratorMode::kIdle) state = wire_->Next();
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kPreempted);
  EXPECT_EQ(robot_->motions_given_up(), 0u);
}

TEST_F(AnswerPacedRobotTest, APauseAndStepsInAMotionChangeNoState) {
  Make(Ideal(), kFreeze);
  const auto unpaused = Contents(Drive(Start()));
  Make(Ideal(), kFreeze);
  std::uint64_t cycle = 0;
  const auto stepped = Contents(Drive(Start(), [&](int k) {
    if (k == 50) {
      robot_->Pause();
      cycle = robot_->state().message_id;
      EXPECT_TRUE(robot_->Step(5));
    }
    if (k == 55) {
      EXPECT_EQ(robot_->state().message_id, cycle + 5);
      EXPECT_EQ(robot_->cycles_left(), 0);
      robot_->Resume();
    }
  }));
  EXPECT_EQ(stepped, unpaused);
}

TEST_F(AnswerPacedRobotTest, APausedMotionIsNotGivenUp) {
  Make(Ideal(), {.answer_timeout = milliseconds(500), .freeze_when_idle = true});
  RobotState state = Stand();
  robot_->Pause();
  // What was under way comes first, then the same state every 100 ms.
  for (std::uint64_t id = 0; id != state.message_id;) {
    id = state.message_id;
    state = wire_->Next();
  }
  const std::uint64_t cycle = robot_->state().message_id;
  for (int i = 0; i < 7; ++i) EXPECT_EQ(wire_->Next().message_id, state.message_id);
  EXPECT_EQ(robot_->motions_given_up(), 0u);
  EXPECT_EQ(robot_->mode(), RobotMode::kMove);
  EXPECT_EQ(robot_->state().message_id, cycle);
}

TEST_F(AnswerPacedRobotTest, BetweenMotionsAPauseRepeatsTheStateAndAStepCountsCycles) {
  Make(test::PandaRobot());
  EXPECT_FALSE(robot_->Step(1)) << "time runs";
  EXPECT_EQ(robot_->cycles_left(), std::nullopt);
  robot_->Pause();
  const std::uint64_t cycle = robot_->state().message_id;
  const RobotState first = Newest(wire_->Next());
  for (std::uint64_t i = 1; i <= 30; ++i) {
    const RobotState state = wire_->Next();
    EXPECT_EQ(state.message_id, first.message_id + i);
    EXPECT_EQ(Content(state), Content(first));
  }
  EXPECT_TRUE(robot_->Step(10));
  while (robot_->cycles_left() != 0) static_cast<void>(wire_->Next());
  EXPECT_EQ(robot_->state().message_id, cycle + 10);
  robot_->Resume();
  static_cast<void>(After(wire_->Next().message_id + 30));
  EXPECT_GT(robot_->state().message_id, cycle + 10);
}

TEST_F(AnswerPacedRobotTest, WhatIsGrantedInAPauseShowsAfterIt) {
  Make(Ideal(), kFreeze);
  robot_->Pause();
  const std::uint64_t cycle = robot_->state().message_id;
  EXPECT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(wire_->Next().motion_generator_mode, MotionGeneratorMode::kIdle);
  }
  EXPECT_EQ(robot_->state().message_id, cycle);
  robot_->Resume();
  RobotState state = wire_->Next();
  while (state.motion_generator_mode == MotionGeneratorMode::kIdle) state = wire_->Next();
  Drive(wire_->Next());
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
}

TEST_F(AnswerPacedRobotTest, AMotionGrantedInAPauseIsWaitedForFromItsEndOn) {
  constexpr Duration kTimeout = milliseconds(50);
  Make(Ideal(), {.answer_timeout = kTimeout, .freeze_when_idle = true});
  robot_->Pause();
  EXPECT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
  const Time granted = clock_.Now();
  while (clock_.Now() < granted + kTimeout) static_cast<void>(wire_->Next());
  const Time resumed = clock_.Now();
  robot_->Resume();
  while (robot_->motions_given_up() == 0) static_cast<void>(wire_->Next());
  EXPECT_GE(clock_.Now() - resumed, kTimeout);
}

TEST_F(AnswerPacedRobotTest, StatesComeInAPauseAlsoOfAMotionThatIsStopped) {
  Make(Ideal(), kFreeze);
  RobotState state = After(Stand().message_id);
  robot_->Pause();
  robot_->StopMove();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(wire_->Next().message_id, state.message_id);
  robot_->Resume();
  while (state.motion_generator_mode != MotionGeneratorMode::kIdle) state = wire_->Next();
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kPreempted);
}

TEST_F(AnswerPacedRobotTest, AfterAResetAMotionHasTheSameStatesAgain) {
  Make(test::PandaRobot(), kFreeze);
  const auto first = Contents(Drive(Start()));
  const std::uint64_t last = robot_->state().message_id;
  EXPECT_TRUE(robot_->Reset({}));
  EXPECT_EQ(Contents(Drive(Start())), first);
  EXPECT_GT(robot_->state().message_id, last) << "ids go on";
}

TEST_F(AnswerPacedRobotTest, AResetPutsTheArmWhereItIsAskedTo) {
  Make(test::PandaRobot(), kFreeze);
  EXPECT_TRUE(robot_->Operate(PanelAction::kPressUserStop));
  JointVector q = test::PandaRobot().q_start;
  q[0] += 0.5;
  EXPECT_TRUE(robot_->Reset(q));
  EXPECT_EQ(robot_->mode(), RobotMode::kIdle);
  EXPECT_EQ(robot_->state().q_d, q);
  q[3] = 0.5;
  EXPECT_THROW(static_cast<void>(robot_->Reset(q)), InputError);
}

TEST_F(AnswerPacedRobotTest, AMotionIsNotReset) {
  Make(Ideal(), kFreeze);
  const RobotState state = Start();
  EXPECT_FALSE(robot_->Reset({}));
  Drive(state);
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
}

TEST_F(AnswerPacedRobotTest, FromASnapshotAMotionHasTheSameStatesAgainAndIdsRise) {
  Make(test::PandaRobot(), kFreeze);
  Drive(Start());
  ASSERT_TRUE(robot_->Save("a"));
  const std::uint64_t cycle = robot_->state().message_id;
  const std::vector<RobotState> first = Drive(Start());
  EXPECT_TRUE(robot_->Operate(PanelAction::kPressUserStop));
  for (int again = 0; again < 2; ++again) {
    ASSERT_TRUE(robot_->Restore("a"));
    EXPECT_EQ(robot_->state().message_id, cycle) << "the robot's time goes back";
    const std::uint64_t last = Newest(wire_->Next()).message_id;
    const std::vector<RobotState> states = Drive(Start());
    EXPECT_EQ(Contents(states), Contents(first));
    EXPECT_GT(states.front().message_id, std::max(last, first.back().message_id));
  }
}

TEST_F(AnswerPacedRobotTest, WhatIsGrantedInAPauseIsInItsSnapshot) {
  Make(test::PandaRobot(), kFreeze);
  robot_->Pause();
  EXPECT_TRUE(robot_->Operate(PanelAction::kPressUserStop));
  ASSERT_TRUE(robot_->Save("a"));
  EXPECT_TRUE(robot_->Operate(PanelAction::kReleaseUserStop));
  ASSERT_TRUE(robot_->Restore("a"));
  robot_->Resume();
  while (wire_->Next().robot_mode != RobotMode::kUserStopped) {
  }
}

TEST_F(AnswerPacedRobotTest, SnapshotsAreTakenAndRestoredBetweenMotionsOnly) {
  Make(Ideal(), kFreeze);
  ASSERT_TRUE(robot_->Save("a"));
  EXPECT_THROW(static_cast<void>(robot_->Restore("b")), InputError);
  const RobotState state = Start();
  EXPECT_FALSE(robot_->Save("b"));
  EXPECT_FALSE(robot_->Restore("a"));
  Drive(state);
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
  for (std::size_t i = 1; i < AnswerPacedRobot::kMostSnapshots; ++i) {
    EXPECT_TRUE(robot_->Save(std::to_string(i)));
  }
  EXPECT_THROW(static_cast<void>(robot_->Save("b")), InputError);
  EXPECT_TRUE(robot_->Save("a")) << "replaces the first";
}

TEST_F(AnswerPacedRobotTest, AStateTheLinkLosesIsNotWaitedFor) {
  RobotConfig config = Ideal();
  faults::ScriptedLoss script;
  for (std::uint64_t first = 10; first < 100000; first += 10) script.runs.push_back({first, 2});
  config.link.state.loss = faults::LossModel(script);
  Make(config, kFreeze);
  const std::vector<RobotState> states = Drive(Start());
  int gaps = 0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    if (states[i].message_id == states[i - 1].message_id + 3) ++gaps;
  }
  EXPECT_GE(gaps, kMotionCycles / 10 - 2);
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
}

TEST_F(AnswerPacedRobotTest, MayBeEndedWhileItWaits) {
  Make(Ideal());
  static_cast<void>(After(Stand().message_id));
  robot_->End();
  EXPECT_EQ(robot_->mode(), RobotMode::kMove);
}

TEST_F(AnswerPacedRobotTest, FrozenTimeRepeatsTheStateAndNothingElse) {
  Make(test::PandaRobot(), kFreeze);
  const RobotState first = wire_->Next();
  for (std::uint64_t i = 1; i <= 30; ++i) {
    const RobotState state = wire_->Next();
    EXPECT_EQ(state.message_id, first.message_id + i);
    EXPECT_EQ(Content(state), Content(first));
  }
}

TEST_F(AnswerPacedRobotTest, ARequestInFrozenTimeTakesEffectInOneCycle) {
  Make(Ideal(), kFreeze);
  setting::Load load;
  load.m_load = 0.5;
  EXPECT_EQ(robot_->Configure(load), SetterStatus::kSuccess);
  RobotState state = wire_->Next();
  while (state.m_load != 0.5) state = wire_->Next();
  for (int i = 0; i < 20; ++i) EXPECT_EQ(Content(wire_->Next()), Content(state));
}

TEST_F(AnswerPacedRobotTest, AMotionInFrozenTimeShowsItsModesUntilItIsCommanded) {
  Make(Ideal(), kFreeze);
  const RobotState state = Start();
  EXPECT_EQ(state.robot_mode, RobotMode::kMove);
  const RobotState again = wire_->Next();  // for whom two states were one
  EXPECT_EQ(again.message_id, state.message_id + 1);
  EXPECT_EQ(Content(again), Content(state));
  Drive(again);
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kSuccess);
}

TEST_F(AnswerPacedRobotTest, AMotionInFrozenTimeThatIsNeverCommandedIsStopped) {
  Make(Ideal(), {.answer_timeout = milliseconds(50), .freeze_when_idle = true});
  RobotState state = Start();
  while (state.motion_generator_mode != MotionGeneratorMode::kIdle) state = wire_->Next();
  EXPECT_EQ(robot_->last_motion().end, MoveStatus::kPreempted);
}

TEST_F(AnswerPacedRobotTest, TheHandsCommandsRunInFrozenTime) {
  RobotConfig config = Ideal();
  config.plant.hand = plant::HandKind::kFrankaHand;
  Make(config, kFreeze);
  const HandTicket ticket = robot_->StartHand(hand::Move{0.02, 0.1}).ticket;
  ASSERT_NE(ticket, 0u);
  while (!robot_->HandOutcome(ticket)) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(robot_->HandOutcome(ticket), HandResult::kSuccess);
  const std::uint32_t then = robot_->hand_state().message_id;
  static_cast<void>(Newest(wire_->Next()));
  for (int i = 0; i < 20; ++i) static_cast<void>(wire_->Next());
  EXPECT_LE(robot_->hand_state().message_id, then + 1);
}

/// A session with two motions, a setting, a reflex and a recovery between them.
class FrozenSessionTest : public AnswerPacedRobotTest {
 protected:
  using States = std::vector<RobotState>;

  /// @param pause  as long as the program takes between two things it does.
  std::vector<States> Session(Duration pause) {
    const auto rest = [&] { std::this_thread::sleep_for(pause); };
    RobotConfig config = test::PandaRobot();  // MuJoCo, with noise
    config.link = {};
    config.link.command.loss = faults::LossModel(faults::IndependentLoss{0.05});
    config.plant.noise.q_rad = 1e-6;
    config.seed = 7;
    Make(config, kFreeze);
    std::vector<States> motions;
    rest();
    motions.push_back(Drive(Start()));
    rest();
    JointVector softer;
    softer.fill(800);
    EXPECT_EQ(robot_->Configure(setting::JointImpedance{softer}), SetterStatus::kSuccess);
    EXPECT_EQ(robot_->Configure(setting::Load{0.3, {}, {}}), SetterStatus::kSuccess);
    rest();
    motions.push_back(Jump(Start()));
    rest();
    Recover();
    rest();
    motions.push_back(Drive(Start()));
    return motions;
  }

  /// A motion that breaks a limit.
  States Jump(RobotState state) {
    state = Newest(state);
    States states;
    RobotCommand command;
    command.q_c = state.q_d;
    while (state.robot_mode == RobotMode::kMove) {
      command.message_id = state.message_id;
      if (states.size() == 5) command.q_c[2] += 0.01;
      wire_->Answer(command);
      state = After(command.message_id);
      states.push_back(state);
    }
    EXPECT_EQ(state.robot_mode, RobotMode::kReflex);
    return states;
  }

  void Recover() {
    while (robot_->AutomaticErrorRecovery() != RecoveryStatus::kSuccess) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    while (robot_->mode() != RobotMode::kIdle) std::this_thread::sleep_for(milliseconds(1));
  }
};

TEST_F(FrozenSessionTest, RepeatsFromEachMotionsFirstCycleOnWhateverPassesBetweenThem) {
  const std::vector<States> prompt = Session(milliseconds(0));
  const std::vector<States> slow = Session(milliseconds(23));
  ASSERT_EQ(prompt.size(), slow.size());
  for (std::size_t i = 0; i < prompt.size(); ++i) {
    EXPECT_EQ(Contents(prompt[i]), Contents(slow[i])) << "motion " << i;
    EXPECT_FALSE(prompt[i].empty());
  }
  EXPECT_NE(prompt[0].front().message_id, slow[0].front().message_id);
}

}  // namespace
}  // namespace twin::robot::answer_paced

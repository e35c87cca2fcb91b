#include "report/run_end.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "record/temporary_folder.h"
#include "report/abort_panels.h"
#include "report/end_samples.h"
#include "report/loss_facts.h"
#include "report/worked_value.h"
#include "twin/core/error_catalogue.h"

namespace twin::report::report_run_end_test {
namespace {

using record::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr std::size_t kJoint = SampleMotion::kJoint;

class RunEndTest : public ::testing::Test {
 protected:
  [[nodiscard]] static Violation Of(RobotError error, double value, double limit,
                                    std::int8_t axis = SampleMotion::kJoint) {
    return {.error = error, .axis = axis, .value = value, .limit = limit};
  }

  /// The motion, answered with q_c `step` off the plan, and refused with `error` and `value`.
  RunEnd Refuse(SampleMotion& motion, double step, RobotError error, double value) {
    motion.AnswerWith(Command(SampleMotion::Planned(motion.k() + 1) + step));
    motion.Abort(Of(error, value, 1), record::CommandFate::kServed);
    return ReadEnds(motion.Finish()).front();
  }

  [[nodiscard]] static record::TickRecord Command(double q_c) {
    record::TickRecord tick;
    tick.action = record::TickAction::kWritten;
    tick.command.q_c[kJoint] = q_c;
    return tick;
  }

  const TemporaryFolder folder_;
  SampleMotion motion_{folder_ / "a.mcap"};
};

TEST_F(RunEndTest, BringsEveryCycleTogetherWithTheAnswerToTheStateBefore) {
  motion_.Serve(80).Abort(Of(RobotError::kJointReflex, 30, 20), record::CommandFate::kNone);
  const RunEnd end = ReadEnds(motion_.Finish()).front();
  ASSERT_EQ(end.cycles.size(), RunEnd::kShown + 1);
  for (std::size_t i = 0; i + 1 < end.cycles.size(); ++i) {
    ASSERT_TRUE(end.cycles[i].answer);
    EXPECT_EQ(end.cycles[i].answer->command.q_c[kJoint], end.cycles[i].cycle.state.q_d[kJoint]);
  }
  EXPECT_FALSE(end.cycles.back().answer);
  EXPECT_EQ(end.last().state.message_id, 1081U);
}

// Independent of the recursion: the third difference of the positions themselves.
double ThirdDifference(std::uint64_t k, double step) {
  const auto q = [](std::uint64_t i) { return SampleMotion::Planned(i); };
  return (q(k) + step - 3 * q(k - 1) + 3 * q(k - 2) - q(k - 3)) / 1e-9;
}

TEST_F(RunEndTest, WorksOutAJerkFromPositions) {
  motion_.Serve(80);
  const double value = ThirdDifference(81, 5e-6);
  const RunEnd end =
      Refuse(motion_, 5e-6, RobotError::kJointMotionGeneratorAccelerationDiscontinuity, value);
  const auto lines = WorkOut(end);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_THAT(lines[0], StartsWith("dq = (q_c - q_d) / T = ("));
  EXPECT_THAT(lines[2], AllOf(StartsWith("dddq = (ddq - ddq_d) / T = ("),
                              HasSubstr(fmt::format("= {:.5g}", value).substr(0, 6))));
}

TEST_F(RunEndTest, WorksOutAccelerationVelocityAndPosition) {
  const auto q = [](std::uint64_t k) { return SampleMotion::Planned(k); };
  const auto lines_for = [&](RobotError error, double value) {
    SampleMotion motion(folder_ / "b.mcap");
    motion.Serve(80);
    return WorkOut(Refuse(motion, 1e-3, error, value)).size();
  };
  const double q_c = q(81) + 1e-3;
  EXPECT_EQ(lines_for(RobotError::kJointMotionGeneratorVelocityDiscontinuity,
                      (q_c - 2 * q(80) + q(79)) / 1e-6),
            2U);
  EXPECT_EQ(
      lines_for(RobotError::kJointMotionGeneratorVelocityLimitsViolation, (q_c - q(80)) / 1e-3),
      1U);
  EXPECT_EQ(lines_for(RobotError::kJointMotionGeneratorPositionLimitsViolation, q_c), 2U);
  EXPECT_EQ(lines_for(RobotError::kJointPositionMotionGeneratorStartPoseInvalid, q_c - q(80)), 1U);
}

TEST_F(RunEndTest, WorksOutWhatAHeldCycleCameTo) {
  motion_.Serve(80).Lose(4, false);
  const RobotState& s = motion_.state();
  const double dq = s.dq_d[kJoint] + 1e-3 * s.ddq_d[kJoint];
  motion_.Abort(Of(RobotError::kJointMotionGeneratorVelocityLimitsViolation, dq, 1),
                record::CommandFate::kHeld);
  EXPECT_THAT(WorkOut(ReadEnds(motion_.Finish()).front()),
              ::testing::ElementsAre(StartsWith("dq = dq_d + T ddq_d, held = ")));
}

TEST_F(RunEndTest, ClaimsNothingWhereItsResultIsAnother) {
  motion_.Serve(80);
  const double value = 1.01 * ThirdDifference(81, 5e-6);
  EXPECT_THAT(WorkOut(Refuse(motion_, 5e-6,
                             RobotError::kJointMotionGeneratorAccelerationDiscontinuity, value)),
              IsEmpty());
}

TEST_F(RunEndTest, SaysThatAMotionMustNotEndWhileItMoves) {
  motion_.Serve(300);
  record::TickRecord tick = Command(SampleMotion::Planned(301));
  tick.action = record::TickAction::kFinished;
  tick.command.motion_generation_finished = true;
  motion_.AnswerWith(tick);
  motion_.Abort(Of(RobotError::kJointMotionGeneratorVelocityDiscontinuity, -400, -7.5),
                record::CommandFate::kServed);
  EXPECT_THAT(WorkOut(ReadEnds(motion_.Finish()).front()),
              ::testing::ElementsAre(HasSubstr("asks to end the motion")));
}

TEST_F(RunEndTest, WorksOutATorqueRate) {
  motion_.Serve(60);
  motion_.state().tau_J_d[kJoint] = 3;
  motion_.Serve(1);
  record::TickRecord tick = Command(0);
  tick.command.tau_J_d[kJoint] = 5;
  motion_.AnswerWith(tick);
  motion_.Abort(Of(RobotError::kControllerTorqueDiscontinuity, 2000, 1000),
                record::CommandFate::kServed);
  EXPECT_THAT(WorkOut(ReadEnds(motion_.Finish()).front()),
              ::testing::ElementsAre(HasSubstr("= (5 - 3) / 0.001 = 2000 Nm/s")));
}

TEST_F(RunEndTest, WorksOutTheJerkOfAPose) {
  motion_.state().motion_generator_mode = MotionGeneratorMode::kCartesianPosition;
  motion_.state().O_T_EE_c[12] = 0.4;
  motion_.state().O_dP_EE_c = {0.1, 0, 0, 0, 0, 0};
  motion_.state().O_ddP_EE_c = {1, 0, 0, 0, 0, 0};
  motion_.Serve(60);
  record::TickRecord tick;
  tick.action = record::TickAction::kWritten;
  tick.command.O_T_EE_c = kIdentityTransform;
  tick.command.O_T_EE_c[12] = 0.4 + 1.11e-4;  // dp 0.111, ddp 11, dddp 10000
  motion_.AnswerWith(tick);
  motion_.Abort(Of(RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity, 1e4, 6500, 0),
                record::CommandFate::kServed);
  const auto lines = WorkOut(ReadEnds(motion_.Finish()).front());
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_THAT(lines[2], HasSubstr("|dddp| = 10000 m/s^3"));
}

TEST_F(RunEndTest, WorksOutTheAccelerationOfAnElbow) {
  motion_.state().motion_generator_mode = MotionGeneratorMode::kCartesianPosition;
  motion_.state().elbow_c = {0.1, -1};
  motion_.state().delbow_c = {0.5, 0};
  motion_.Serve(60);
  record::TickRecord tick;
  tick.action = record::TickAction::kWritten;
  tick.command.valid_elbow = true;
  tick.command.elbow_c = {0.1 + 0.52e-3, -1};
  motion_.AnswerWith(tick);
  motion_.Abort(Of(RobotError::kCartesianMotionGeneratorVelocityDiscontinuity, 20, 10, 2),
                record::CommandFate::kServed);
  EXPECT_THAT(WorkOut(ReadEnds(motion_.Finish()).front()).back(), HasSubstr("= 20 rad/s^2"));
}

TEST_F(RunEndTest, BlamesTheLossRightBeforeACommandThatJumps) {
  motion_.Serve(60).Lose(3, true);
  motion_.Abort(Of(RobotError::kJointMotionGeneratorAccelerationDiscontinuity, 5000, 3750),
                record::CommandFate::kServed);
  EXPECT_THAT(
      JudgeLosses(ReadEnds(motion_.Finish()).front()),
      AllOf(StartsWith("Likely"), HasSubstr("after 3 in a row"), HasSubstr("10 times the jerk")));
}

TEST_F(RunEndTest, ALossSomeCyclesBeforeIsPossibleOrUnlikely) {
  const auto judged = [&](int served_after, RobotError error) {
    SampleMotion motion(folder_ / "b.mcap");
    motion.Serve(60).Lose(3, true).Serve(served_after);
    motion.Abort(Of(error, 5000, 3750), record::CommandFate::kServed);
    return JudgeLosses(ReadEnds(motion.Finish()).front());
  };
  const auto jerk = RobotError::kJointMotionGeneratorAccelerationDiscontinuity;
  EXPECT_THAT(judged(4, jerk), AllOf(StartsWith("Possible"), HasSubstr("5 cycles before")));
  EXPECT_THAT(judged(30, jerk), StartsWith("Unlikely"));
  EXPECT_THAT(judged(0, RobotError::kJointReflex), StartsWith("Unlikely"));
  EXPECT_THAT(judged(60, jerk), StartsWith("No:"));
}

TEST_F(RunEndTest, ACycleThatItselfHadNoCommandIsTheLoss) {
  motion_.Serve(60).Lose(3, true);
  motion_.SetLost(4);
  motion_.Abort(Of(RobotError::kJointMotionGeneratorPositionLimitsViolation, 2, 1.7),
                record::CommandFate::kHeld);
  EXPECT_THAT(JudgeLosses(ReadEnds(motion_.Finish()).front()),
              StartsWith("Yes: this cycle had no command"));
}

TEST_F(RunEndTest, SaysWhereTheCommandsOfHeldCyclesWent) {
  motion_.Serve(40).Lose(5, true).Lose(3, false);
  record::TickRecord silent;
  silent.action = record::TickAction::kSkipped;
  motion_.AnswerWith(silent).Lose(1, false);
  motion_.SetLost(10);
  motion_.Abort(Of(RobotError::kCommunicationConstraintsViolation, 20, 20, -1),
                record::CommandFate::kHeld);
  const RunEnd end = ReadEnds(motion_.Finish()).front();
  EXPECT_THAT(CountFates(end),
              AllOf(StartsWith("40 cycles served, 10 held, 0 in which"),
                    HasSubstr("4 because the workstation did not see the state"),
                    HasSubstr("1 because the workstation saw the state, but wrote nothing"),
                    HasSubstr("5 although the workstation wrote a command")));
  EXPECT_THAT(CountTicks(end), HasSubstr("left 1 state unanswered"));
  EXPECT_EQ(JudgeLosses(end), "") << "the error says it";
}

TEST_F(RunEndTest, CountsTargetsThatWereUsedTwice) {
  motion_.Serve(60);
  record::TickRecord tick = Command(SampleMotion::Planned(61));
  tick.deposit_time = Time(59 * kCycle + Duration(100'000));  // that of the answer before
  motion_.AnswerWith(tick);
  motion_.Abort(Of(RobotError::kJointMotionGeneratorAccelerationDiscontinuity, 5000, 3750),
                record::CommandFate::kServed);
  EXPECT_THAT(CountTicks(ReadEnds(motion_.Finish()).front()), HasSubstr("formed 1 of 51 commands"));
}

TEST_F(RunEndTest, AnUneventfulWorkstationIsWorthNoWord) {
  motion_.Serve(60).Abort(Of(RobotError::kJointReflex, 30, 20), record::CommandFate::kNone);
  EXPECT_EQ(CountTicks(ReadEnds(motion_.Finish()).front()), "");
}

/// Every error with every axis it can have, and none.
TEST_F(RunEndTest, EveryErrorHasPanelsWithOneValuePerCycle) {
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    for (const std::int8_t axis : {-1, 0, 1, 2, 5, 6}) {
      SampleMotion motion(folder_ / "b.mcap");
      motion.Serve(10);
      motion.Abort(Of(static_cast<RobotError>(i), 7, 5, axis), record::CommandFate::kServed);
      const RunEnd end = ReadEnds(motion.Finish()).front();
      const auto panels = EndPanels(end);
      ASSERT_FALSE(panels.empty()) << i << " axis " << int{axis};
      for (const EndPanel& panel : panels) {
        ASSERT_FALSE(panel.curves.empty()) << panel.title;
        for (const EndCurve& curve : panel.curves) {
          EXPECT_EQ(curve.values.size(), end.cycles.size()) << panel.title;
        }
      }
    }
  }
}

TEST_F(RunEndTest, WhatBrokeItsLimitComesFirstWithValueAndLimit) {
  struct Case {
    RobotError error;
    std::int8_t axis;
    const char* title;
  };
  for (const Case& c :
       {Case{RobotError::kJointPositionLimitsViolation, 1, "joint 2: position"},
        Case{RobotError::kJointVelocityViolation, 1, "joint 2: velocity"},
        Case{RobotError::kCartesianVelocityViolation, 0, "speed of the end effector"},
        Case{RobotError::kPowerLimitViolation, -1,
             "power of the joints together, by the torques measured"},
        Case{RobotError::kSelfCollisionAvoidanceViolation, -1, "least distance of the arm's parts"},
        Case{RobotError::kJointReflex, 3, "joint 4: external torque"},
        Case{RobotError::kCartesianReflex, 2, "external force on K, z of K"},
        Case{RobotError::kCartesianReflex, 3, "external torque on K, R of K"},
        Case{RobotError::kJointMotionGeneratorVelocityDiscontinuity, 0,
             "joint 1: acceleration of the reference"},
        Case{RobotError::kCartesianMotionGeneratorVelocityDiscontinuity, 0,
             "end effector: acceleration"},
        Case{RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity, 1,
             "end effector, rotation: jerk"},
        Case{RobotError::kCartesianMotionGeneratorVelocityLimitsViolation, 2, "elbow: velocity"},
        Case{RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity, 6,
             "joint 7: jerk of the reference"},
        Case{RobotError::kCommunicationConstraintsViolation, -1,
             "cycles in a row without a command"},
        Case{RobotError::kControllerTorqueDiscontinuity, 4,
             "joint 5: rate of the commanded torque"},
        Case{RobotError::kTauJRangeViolation, 4, "joint 5: measured torque, gravity included"}}) {
    SampleMotion motion(folder_ / "b.mcap");
    motion.Serve(10);
    motion.Abort(Of(c.error, -7, -5, c.axis), record::CommandFate::kServed);
    const auto panels = EndPanels(ReadEnds(motion.Finish()).front());
    EXPECT_EQ(panels.front().title, c.title);
    EXPECT_EQ(panels.front().offender, -7) << c.title;
    EXPECT_THAT(panels.front().limits, ::testing::Contains(-5)) << c.title;
  }
}

TEST_F(RunEndTest, HeldCyclesAreShadedInTheFigure) {
  motion_.Serve(10).Lose(2, true);
  motion_.Abort(Of(RobotError::kJointReflex, 30, 20), record::CommandFate::kNone);
  const RunEnd end = ReadEnds(motion_.Finish()).front();
  const Figure figure = EndFigure(end, EndPanels(end));
  EXPECT_EQ(figure.values.at("held"), 2);
  EXPECT_EQ(figure.values.at("held_1"), -2);
  EXPECT_EQ(figure.values.at("held_2"), -1);
  const std::string shade = " fill = 'rgb(251, 227, 229)'";
  const std::string svg = DrawPlot("run/", figure);
  std::size_t shaded = 0;
  for (std::size_t at = svg.find(shade); at != std::string::npos; at = svg.find(shade, at + 1)) {
    ++shaded;
  }
  EXPECT_EQ(shaded, 2 * (EndPanels(end).size() + 1));
}

TEST_F(RunEndTest, FindsTheClosestApproach) {
  motion_.Serve(1000).Abort(Of(RobotError::kJointReflex, 30, 20), record::CommandFate::kNone);
  const RunEnd end = ReadEnds(motion_.Finish()).front();
  double share = 0;
  for (const Approach& approach : end.approach.Closest()) {
    if (approach.what != "dq_d, velocity of the reference") continue;
    // dq = 0.6 sin(3 t), largest at t = pi / 6.
    EXPECT_EQ(approach.axis, static_cast<int>(kJoint));
    EXPECT_NEAR(approach.value, 0.6, 1e-5);
    EXPECT_EQ(approach.limit, 2.175);
    EXPECT_NEAR(approach.time, 0.5236, 2e-3);
    share = approach.share;
  }
  EXPECT_NEAR(share, 0.6 / 2.175, 1e-5);
}

TEST_F(RunEndTest, WhatTheRobotDoesByItselfIsNoApproach) {
  motion_.Serve(100);
  motion_.state().dq_d[0] = 2.1;
  motion_.PassBy();
  const RunEnd end = ReadEnds(motion_.Finish()).front();
  EXPECT_FALSE(end.approach.Closest().empty());
  for (const Approach& approach : end.approach.Closest()) {
    EXPECT_LT(approach.share, 0.9) << approach.what;
  }
}

}  // namespace
}  // namespace twin::report::report_run_end_test

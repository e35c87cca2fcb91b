// A robot that keeps what it is commanded within its limits, behind a client without any manners
// and a wire that loses up to 19 commands in a row; beside it the same robot without.
#include "twin/robot/command_keeper.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "robot/robot_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"
#include "twin/plant/ideal_plant.h"

namespace twin::robot::robot_command_keeper_test {
namespace {

using std::chrono::milliseconds;

/// Answers every state at once with values that jump about.
class WildClient final : public rt::EventHandler {
 public:
  void OnEvent(Time, std::uint64_t) noexcept override {
    if (robot->states().has_new()) Answer(robot->states().Take());
  }
  Robot* robot = nullptr;

 private:
  void Answer(const RobotState& state) {
    RobotCommand command;
    command.message_id = state.message_id;
    const bool first = answered_++ == 0;
    const double jump = first ? 0 : Jump();
    command.q_c = state.q_d;
    for (const std::size_t joint : {0, 6}) {  // by which the arm cannot touch itself
      command.q_c[joint] += jump;
      command.dq_c[joint] = jump;
    }
    command.O_T_EE_c = state.O_T_EE_c;
    for (std::size_t i = 12; i < 15; ++i) command.O_T_EE_c[i] += 0.1 * jump;
    command.O_dP_EE_c = {jump, -jump, jump, 0, jump, 0};
    robot->Send(command);
  }
  double Jump() { return std::sin(1e3 * random_.Uniform(++answered_)); }

  const Random random_{3, RandomStream::kTest};
  std::uint64_t answered_ = 0;
};

class Tally final : public record::RecordSink {
 public:
  void Put(const record::CycleRecord& record) noexcept override {
    if (record.violated && violations++ == 0) first = record.violation;
    served += record.fate == record::CommandFate::kServed ? 1 : 0;
  }
  void Put(const record::TickRecord&) noexcept override {}
  int violations = 0;
  int served = 0;
  Violation first;
};

class CommandKeeperTest : public ::testing::TestWithParam<MotionGeneratorMode> {
 protected:
  [[nodiscard]] static Tally Run(std::optional<int> viability) {
    RobotConfig config = test::PandaRobot();
    config.viability = viability;
    faults::ScriptedLoss bursts;
    for (std::uint64_t k = 1; k < 20; ++k) bursts.runs.push_back({97 * k, 19});
    config.link.command.loss = faults::LossModel(bursts);
    rt::EventQueue events;
    WildClient client;
    Tally tally;
    Robot robot(config, std::make_unique<plant::IdealPlant>(), events, client, &tally);
    client.robot = &robot;
    robot.Begin();
    EXPECT_EQ(robot.Move({ControllerMode::kJointImpedance, GetParam()}),
              MoveStatus::kMotionStarted);
    while (events.Now() < Time(milliseconds(2000))) EXPECT_TRUE(events.RunNext());
    return tally;
  }
};

TEST_P(CommandKeeperTest, NoLimitIsBrokenWhateverIsCommandedAndLost) {
  const Tally tally = Run(19);
  EXPECT_EQ(tally.violations, 0) << Name(tally.first.error) << " of " << int{tally.first.axis};
  EXPECT_GT(tally.served, 1000);
}

TEST_P(CommandKeeperTest, WithoutItTheRobotEndsTheMotion) {
  EXPECT_GT(Run({}).violations, 0);
}

INSTANTIATE_TEST_SUITE_P(Interfaces, CommandKeeperTest,
                         ::testing::Values(MotionGeneratorMode::kJointPosition,
                                           MotionGeneratorMode::kJointVelocity),
                         [](const auto& param) {
                           return param.param == MotionGeneratorMode::kJointPosition
                                      ? "JointPosition"
                                      : "JointVelocity";
                         });

TEST(CommandKeeperTest, WhatIsAdmissiblePassesBitForBit) {
  const CommandKeeper keeper(test::PandaLimits(), test::PandaCartesianLimits(), 19);
  RobotState state;
  state.q_d = test::kReady;
  state.O_T_EE_c = model::ArmModel::Panda().Pose(model::Frame::kFlange, state.q_d);
  for (const auto mode :
       {MotionGeneratorMode::kIdle, MotionGeneratorMode::kJointPosition,
        MotionGeneratorMode::kJointVelocity, MotionGeneratorMode::kCartesianPosition,
        MotionGeneratorMode::kCartesianVelocity}) {
    state.motion_generator_mode = mode;
    RobotCommand command;
    command.q_c = state.q_d;
    command.q_c[0] += 1e-9;
    command.dq_c[1] = 1e-6;
    command.O_T_EE_c = state.O_T_EE_c;
    command.O_T_EE_c[13] += 1e-9;
    command.O_dP_EE_c[2] = 1e-6;
    command.tau_J_d[3] = 5;
    command.motion_generation_finished = true;
    const RobotCommand kept = keeper.Keep(state, command);
    EXPECT_EQ(kept.q_c, command.q_c);
    EXPECT_EQ(kept.dq_c, command.dq_c);
    EXPECT_EQ(kept.O_T_EE_c, command.O_T_EE_c);
    EXPECT_EQ(kept.O_dP_EE_c, command.O_dP_EE_c);
    EXPECT_EQ(kept.tau_J_d, command.tau_J_d);
    EXPECT_TRUE(kept.motion_generation_finished);
  }
}

TEST(CommandKeeperTest, TwistsAreKeptToTheJerkOfTheEndEffector) {
  const CommandKeeper keeper(test::PandaLimits(), test::PandaCartesianLimits(), 19);
  RobotState state;
  state.q_d = test::kReady;
  state.O_T_EE_c = model::ArmModel::Panda().Pose(model::Frame::kFlange, state.q_d);
  state.motion_generator_mode = MotionGeneratorMode::kCartesianVelocity;
  RobotCommand command;
  command.O_dP_EE_c[0] = 1;
  const double v = keeper.Keep(state, command).O_dP_EE_c[0];
  EXPECT_GT(v, 0);
  EXPECT_LE(v, 1e-6 * test::PandaCartesianLimits().translation.dddp_max);
}

TEST(CommandKeeperTest, AllocatesNothing) {
  const CommandKeeper keeper(test::PandaLimits(), test::PandaCartesianLimits(), 19);
  RobotState state;
  state.q_d = test::kReady;
  state.O_T_EE_c = model::ArmModel::Panda().Pose(model::Frame::kFlange, state.q_d);
  RobotCommand command;
  command.O_T_EE_c = state.O_T_EE_c;
  command.O_T_EE_c[12] += 0.01;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    state.motion_generator_mode = static_cast<MotionGeneratorMode>(i % 5);
    static_cast<void>(keeper.Keep(state, command));
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::robot::robot_command_keeper_test

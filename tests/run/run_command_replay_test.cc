#include "twin/run/command_replay.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "controllers/registration.h"
#include "plugins/backends.h"
#include "twin/core/body_interface.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::run::run_command_replay_test {
namespace {

/// What a log has.
struct Logged final : record::RecordSink {
  void Put(const record::CycleRecord& record) noexcept override { cycles.push_back(record); }
  void Put(const record::TickRecord& record) noexcept override {
    if (record.command.message_id != 0) commands.emplace(record.command.message_id, record.command);
  }
  std::vector<record::CycleRecord> cycles;
  std::map<std::uint64_t, RobotCommand> commands;  // by the state that they answer
};

class CommandReplayTest : public ::testing::Test {
 protected:
  CommandReplayTest() {
    plugins::RegisterMujoco(backends_);
    controllers::RegisterControllers(controllers_);
  }

  [[nodiscard]] scenario::Scenario Load(const std::string& name) const {
    return scenario::Load(files_.models / "scenarios" / name);
  }

  [[nodiscard]] Logged RunOf(const scenario::Scenario& scenario) const {
    Logged log;
    run::Run run(scenario, {backends_, controllers_}, files_, &log);
    (void)run.Execute({});
    return log;
  }

  /// Replays a log, and expects each of its states, to the bit.
  void ExpectSame(const scenario::Scenario& scenario, const Logged& log) const {
    CommandReplay replay(scenario, files_);
    RobotMode before = RobotMode::kIdle;
    for (const record::CycleRecord& logged : log.cycles) {
      const RobotState& state = logged.state;
      if (state.robot_mode == RobotMode::kMove && before != RobotMode::kMove) {
        ASSERT_EQ(replay.Start({state.controller_mode, state.motion_generator_mode}),
                  MoveStatus::kMotionStarted);
      }
      before = state.robot_mode;
      const bool was_served = logged.fate == record::CommandFate::kServed;
      const RobotCommand* const command =
          was_served ? &log.commands.at(state.message_id - 1) : nullptr;
      const record::CycleRecord& replayed = replay.Cycle(command);
      const RobotState& again = replayed.state;
      ASSERT_EQ(again.message_id, state.message_id);
      SCOPED_TRACE(state.message_id);
      ASSERT_EQ(replayed.fate, logged.fate);
      ASSERT_EQ(again.errors, state.errors);
      ASSERT_EQ(again.robot_mode, state.robot_mode);
      ASSERT_EQ(again.q, state.q);
      ASSERT_EQ(again.dq, state.dq);
      ASSERT_EQ(again.tau_J, state.tau_J);
      ASSERT_EQ(again.q_d, state.q_d);
      ASSERT_EQ(again.dq_d, state.dq_d);
      ASSERT_EQ(again.tau_ext_hat_filtered, state.tau_ext_hat_filtered);
      ASSERT_EQ(again.O_F_ext_hat_K, state.O_F_ext_hat_K);
    }
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
};

TEST_F(CommandReplayTest, GivesTheStatesOfTheRunToTheBit) {
  for (const char* const name :
       {"smoke.yaml", "packet_loss.yaml", "torque.yaml", "cartesian_pose.yaml"}) {
    SCOPED_TRACE(name);
    const scenario::Scenario scenario = Load(name);
    const Logged log = RunOf(scenario);
    ASSERT_GT(log.cycles.size(), 500u);
    ExpectSame(scenario, log);
  }
}

TEST_F(CommandReplayTest, AbortsInTheSameCycle) {
  for (const char* const name : {"outage.yaml", "wrong_load.yaml", "collision.yaml"}) {
    SCOPED_TRACE(name);
    const scenario::Scenario scenario = Load(name);
    const Logged log = RunOf(scenario);
    ExpectSame(scenario, log);
  }
}

TEST_F(CommandReplayTest, DiffersWithoutACommand) {
  const scenario::Scenario scenario = Load("smoke.yaml");
  const Logged log = RunOf(scenario);
  CommandReplay replay(scenario, files_);
  for (std::size_t i = 0; i < log.cycles.size(); ++i) {
    EXPECT_EQ(replay.Cycle(nullptr).fate, record::CommandFate::kNone);
  }
  EXPECT_NE(replay.Cycle(nullptr).state.q, log.cycles.back().state.q);
}

TEST_F(CommandReplayTest, StartsWhereTold) {
  JointVector q{0.1, -0.8, 0.1, -2.3, 0.1, 1.5, 0.8};
  CommandReplay replay(Load("smoke.yaml"), files_, q);
  const record::CycleRecord& record = replay.Cycle(nullptr);
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(record.state.q_d[i], q[i], 1e-12);
}

}  // namespace
}  // namespace twin::run::run_command_replay_test

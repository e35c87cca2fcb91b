#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "controllers/joint_trajectory.h"
#include "plugins/backends.h"
#include "twin/plant/truth_probe.h"
#include "twin/run/run.h"

namespace twin::run::run_vacuum_test {
namespace {

/// models/scenarios/vacuum.yaml, which sucks on a box and lifts it.
class VacuumRunTest : public ::testing::Test {
 protected:
  VacuumRunTest() {
    plugins::RegisterMujoco(backends_);
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest& request) {
      controllers::JointTrajectoryOptions options;
      options.command_interface = request.interface;
      return std::make_unique<controllers::JointTrajectoryController>(request.trajectory, options);
    });
  }

  RunResult Execute() {
    run::Run run(scenario_, {backends_, controllers_}, files_, nullptr);
    const plant::TruthProbe& truth = *run.connection().truth;
    const int box = mj_name2id(&truth.model(), mjOBJ_BODY, "box");
    RunHooks hooks;
    hooks.event = [this](Time, std::string_view kind, std::string_view text) {
      if (kind == "hand") events_.emplace_back(text);
    };
    const RunResult result = run.Execute(hooks);
    height_ = truth.data().xpos[3 * box + 2];
    return result;
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
  scenario::Scenario scenario_ = scenario::Load(files_.models / "scenarios" / "vacuum.yaml");
  std::vector<std::string> events_;
  double height_ = 0;  ///< of the box's centre at the end, m; 0.262 where it stands
};

TEST_F(VacuumRunTest, TheArmLiftsWhatThePumpHolds) {
  const RunResult result = Execute();
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_NEAR(height_, 0.262 + 0.15, 5e-3);
  EXPECT_LT(result.final_error, 1e-3);
  ASSERT_TRUE(result.hand);
  EXPECT_TRUE(result.hand->state.is_grasped);
  ASSERT_EQ(result.hand->commands.size(), 1u);
  EXPECT_EQ(result.hand->commands[0].result, HandResult::kSuccess);
  ASSERT_TRUE(result.hand->state.pump);
  EXPECT_NEAR(result.hand->state.pump->vacuum, 600, 10);
  ASSERT_EQ(events_.size(), 2u) << "a begin and an end";
  EXPECT_TRUE(events_[1].starts_with("Vacuum: success; 4")) << events_[1];
}

TEST_F(VacuumRunTest, WhatItDropsFalls) {
  scenario_.hand.push_back({std::chrono::milliseconds(8000), hand::DropOff{.timeout_ms = 500}});
  const RunResult result = Execute();
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_NEAR(height_, 0.262, 5e-3) << "on the table again";
  ASSERT_TRUE(result.hand);
  EXPECT_EQ(result.hand->commands[1].result, HandResult::kSuccess);
  EXPECT_TRUE(result.hand->state.pump->part_detached);
}

TEST_F(VacuumRunTest, DoesTheSameInEveryRun) {
  const RunResult first = Execute();
  const double height = height_;
  const RunResult second = Execute();
  EXPECT_EQ(first.states_hash, second.states_hash);
  EXPECT_EQ(height_, height);
}

}  // namespace
}  // namespace twin::run::run_vacuum_test

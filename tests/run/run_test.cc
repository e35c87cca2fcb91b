#include "twin/run/run.h"

#include <filesystem>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "controllers/joint_trajectory.h"
#include "plugins/backends.h"
#include "scenario/scenario_examples.h"
#include "twin/core/error.h"

namespace twin::run::run_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A short motion of the ideal plant over a link with jitter; the tests change it.
scenario::Scenario ShortScenario() {
  return scenario::Parse(R"(name: short
plant: {kind: ideal}
link:
  state_delay: {log_normal: {median: 60 us, sigma: 0.4}}
  command_delay: {log_normal: {median: 60 us, sigma: 0.4}}
tick: {cost: 13 us}
controller: {clock_drift: 20 ppm, cost: 60 us}
motion:
  trajectory:
    unit: rad
    velocity_scale: 0.1
    acceleration_scale: 0.1
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
)",
                         "short.yaml");
}

class AssemblyTest : public ::testing::Test {
 protected:
  AssemblyTest() {
    plugins::RegisterMujoco(backends_);
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest& request) {
      controllers::JointTrajectoryOptions options;
      options.command_interface = request.interface;
      return std::make_unique<controllers::JointTrajectoryController>(request.trajectory, options);
    });
  }

  [[nodiscard]] RunResult Execute(const scenario::Scenario& scenario,
                                  const RunHooks& hooks = {}) const {
    run::Run run(scenario, {backends_, controllers_}, files_, nullptr);
    return run.Execute(hooks);
  }

  backend::Registry backends_;
  control::ControllerRegistry controllers_;
  const RunFiles files_{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
};

TEST_F(AssemblyTest, BringsTheArmToTheLastWaypoint) {
  const RunResult result = Execute(ShortScenario());
  EXPECT_EQ(result.report.end, backend::MotionEnd::kSuccess) << result.report.failure;
  EXPECT_LT(result.final_error, 1e-3);
  EXPECT_GT(result.counts.served, 100u);
}

TEST_F(AssemblyTest, RepeatsWithTheSeedAndDiffersWithAnother) {
  scenario::Scenario scenario = ShortScenario();
  const std::uint64_t first = Execute(scenario).states_hash;
  EXPECT_EQ(Execute(scenario).states_hash, first);
  scenario.seed = 2;
  EXPECT_NE(Execute(scenario).states_hash, first);
}

TEST_F(AssemblyTest, RunsTheVelocityInterface) {
  scenario::Scenario scenario = ShortScenario();
  scenario.motion.interface = control::CommandInterface::kJointVelocity;
  scenario.tick.generator = loop::Generator::kNone;
  scenario.controller.clock_drift_ppm = 0;
  scenario.controller.phase = std::chrono::microseconds(500);
  const RunResult result = Execute(scenario);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kSuccess) << result.report.failure;
  EXPECT_LT(result.final_error, 1e-3);
}

TEST_F(AssemblyTest, ReportsAMotionThatLosesAllItsCommands) {
  scenario::Scenario scenario = ShortScenario();
  scenario.link.command.delay = {faults::ConstantDelay{std::chrono::milliseconds(2)}};
  const RunResult result = Execute(scenario);
  EXPECT_NE(result.report.end, backend::MotionEnd::kSuccess);
  EXPECT_FALSE(result.report.failure.empty());
}

TEST_F(AssemblyTest, StopsWhenInterrupted) {
  volatile bool interrupted = false;
  RunHooks hooks;
  hooks.interrupted = &interrupted;
  hooks.progress = [&](Time now, Duration planned) {
    EXPECT_GT(planned, Duration::zero());
    if (now > Time(std::chrono::milliseconds(150))) interrupted = true;
  };
  const RunResult result = Execute(ShortScenario(), hooks);
  EXPECT_EQ(result.report.end, backend::MotionEnd::kPreempted);
  EXPECT_EQ(result.report.failure, "interrupted");
}

TEST_F(AssemblyTest, StartsWhereTheScenarioSays) {
  scenario::Scenario scenario = ShortScenario();
  scenario.robot.q_start = scenario.motion.waypoints.front().q;
  (*scenario.robot.q_start)[0] += 0.05;
  EXPECT_THAT([&] { (void)Execute(scenario); },
              ThrowsMessage<InputError>(
                  HasSubstr("robot.q_start: joint 1 rests at 0.05 rad but the trajectory")));
}

TEST_F(AssemblyTest, RefusesAStartOutsideTheLimits) {
  scenario::Scenario scenario = ShortScenario();
  scenario.robot.q_start = JointVector{};
  EXPECT_THAT([&] { (void)Execute(scenario); },
              ThrowsMessage<InputError>(HasSubstr("robot.q_start: joint 4 is at 0 rad")));
}

TEST_F(AssemblyTest, NamesTheWaypointThatIsOutsideTheLimits) {
  scenario::Scenario scenario = ShortScenario();
  scenario.motion.waypoints[1].q[3] = 0.5;
  EXPECT_THAT([&] { (void)Execute(scenario); },
              ThrowsMessage<InputError>(HasSubstr("short.yaml:15")));
}

TEST_F(AssemblyTest, NamesWhatThereIsForAnUnknownBackendOrController) {
  scenario::Scenario scenario = ShortScenario();
  scenario.backend = "gazebo";
  EXPECT_THAT([&] { (void)Execute(scenario); },
              ThrowsMessage<InputError>(HasSubstr("there are: mujoco")));
  scenario = ShortScenario();
  scenario.controller.type = "pid";
  EXPECT_THAT([&] { (void)Execute(scenario); },
              ThrowsMessage<InputError>(HasSubstr("there are: joint_trajectory")));
}

TEST_F(AssemblyTest, NamesASceneThatIsNotThere) {
  scenario::Scenario scenario = ShortScenario();
  scenario.scene = "scenes/nowhere.xml";
  EXPECT_THAT([&] { (void)Execute(scenario); },
              ThrowsMessage<InputError>(HasSubstr("nowhere.xml")));
}

}  // namespace
}  // namespace twin::run::run_test

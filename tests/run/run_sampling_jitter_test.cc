// What the paper promises of its reference generator, on the standard trajectories: sampling jitter
// of a few microseconds aborts a raw position stream and not the generator's.
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "controllers/joint_trajectory.h"
#include "plugins/backends.h"
#include "twin/run/run.h"

namespace twin::run::run_sampling_jitter_test {
namespace {

using std::chrono::microseconds;

/// How the trajectory is brought to the robot.
struct Way {
  loop::Generator generator = loop::Generator::kJoint;
  double clock_drift_ppm = 0;
  /// Of the controller's wake-ups; absent: the scenario's.
  std::optional<Duration> phase{};
};

class ScenarioSamplingJitterTest : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  ScenarioSamplingJitterTest() {
    plugins::RegisterMujoco(backends_);
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest& request) {
      return std::make_unique<controllers::JointTrajectoryController>(request.trajectory);
    });
  }

  /// A trajectory of the ideal plant over a link without jitter and losses, sampled by a loop that
  /// wakes with a jitter of 4 us (standard deviation) and costs 60 us.
  [[nodiscard]] RunResult Run(const char* name, const Way& way) const {
    scenario::Scenario scenario = scenario::Load(models_ / "scenarios" / name);
    scenario.seed = GetParam();
    scenario.record = false;
    scenario.plant.kind = robot::PlantKind::kIdeal;
    scenario.motion.interface = control::CommandInterface::kJointPosition;
    scenario.tick.generator = way.generator;
    scenario.tick.viability.reset();
    scenario.link.state = {};
    scenario.link.command = {};
    scenario.link.state.delay.law = faults::ConstantDelay{microseconds(80)};
    scenario.controller.cost.law = faults::ConstantDelay{microseconds(60)};
    scenario.controller.wake_delay.law = faults::NormalDelay{microseconds(20), microseconds(4)};
    scenario.controller.clock_drift_ppm = way.clock_drift_ppm;
    if (way.phase) scenario.controller.phase = *way.phase;
    run::Run run(scenario, {backends_, controllers_}, {models_, {}, {}, false}, nullptr);
    return run.Execute();
  }

  const std::filesystem::path models_ = std::filesystem::path(TWIN_SOURCE_DIR) / "models";
  backend::Registry backends_;
  control::ControllerRegistry controllers_;
};

TEST_P(ScenarioSamplingJitterTest, TheRawStreamOfTheCanonicalTrajectoryAborts) {
  const RunResult result = Run("canonical.yaml", {.generator = loop::Generator::kNone});
  EXPECT_EQ(result.report.end, backend::MotionEnd::kAborted);
  EXPECT_TRUE(result.report.errors[static_cast<std::size_t>(
      RobotError::kJointMotionGeneratorAccelerationDiscontinuity)])
      << FormatErrors(result.report.errors);
}

TEST_P(ScenarioSamplingJitterTest, BehindTheGeneratorItReachesItsGoal) {
  const RunResult result = Run("canonical.yaml", {});
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_LT(result.final_error, 1e-3);
}

TEST_P(ScenarioSamplingJitterTest, SoItDoesWithTwoFreeRunningLoops50PpmApart) {
  for (const double drift : {50.0, -50.0}) {
    const RunResult result = Run("canonical.yaml", {.clock_drift_ppm = drift});
    EXPECT_TRUE(result.report.succeeded()) << drift << " ppm: " << result.report.failure;
  }
}

TEST_P(ScenarioSamplingJitterTest, TheGeneratorsPromiseEndsOnABriskTrajectory) {
  // A deposit consumed twice beside a skipped one makes a jerk of 2 ddq / T: at 0.6 of the
  // acceleration limits that is beyond the jerk limits. It happens where deposits fall on the
  // arrival of states: the grid begins at the first arrival, and wake-up and work take 80 us.
  const RunResult result = Run("brisk.yaml", {.phase = microseconds(920)});
  EXPECT_EQ(result.report.end, backend::MotionEnd::kAborted) << result.report.failure;
}

INSTANTIATE_TEST_SUITE_P(Seeds, ScenarioSamplingJitterTest, ::testing::Range<std::uint64_t>(1, 6));

}  // namespace
}  // namespace twin::run::run_sampling_jitter_test

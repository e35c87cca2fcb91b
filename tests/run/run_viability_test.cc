// What the viability filter promises, where it counts: the robot's own checks, behind the whole
// loop. On the brisk trajectory the paper's generator aborts under jitter, and a raw stream under
// losses; with the filter behind them, they do not.
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include <gtest/gtest.h>

#include "controllers/joint_trajectory.h"
#include "plugins/backends.h"
#include "twin/run/run.h"

namespace twin::run::run_viability_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

class ViabilityTest : public ::testing::Test {
 protected:
  ViabilityTest() {
    plugins::RegisterMujoco(backends_);
    controllers_.Add("joint_trajectory", [](const control::ControllerRequest& request) {
      controllers::JointTrajectoryOptions options;
      options.command_interface = request.interface;
      return std::make_unique<controllers::JointTrajectoryController>(request.trajectory, options);
    });
  }

  /// Runs of lost commands, `longest` of them in a row, every 211 ms; the seed shifts them.
  static void Lose(scenario::Scenario& scenario, std::uint32_t longest) {
    scenario::ScriptedLoss script;
    for (int k = 1; k < 34; ++k) {
      script.bursts.push_back(
          {milliseconds(211 * k + static_cast<int>(scenario.seed) * 37), longest});
    }
    scenario.link.command.loss.law = script;
  }
  [[nodiscard]] RunResult Run(const scenario::Scenario& scenario) const {
    run::Run run(scenario, {backends_, controllers_}, {models_, {}, {}, false}, nullptr);
    return run.Execute();
  }

  const std::filesystem::path models_ = std::filesystem::path(TWIN_SOURCE_DIR) / "models";
  backend::Registry backends_;
  control::ControllerRegistry controllers_;
};

class ScenarioViabilityTest : public ViabilityTest,
                              public ::testing::WithParamInterface<std::uint64_t> {
 protected:
  /// The brisk trajectory as joint positions behind the paper's generator, on the ideal plant, by a
  /// loop whose deposits fall on the arrival of states.
  [[nodiscard]] scenario::Scenario Brisk() const {
    scenario::Scenario scenario = scenario::Load(models_ / "scenarios" / "brisk.yaml");
    scenario.seed = GetParam();
    scenario.record = false;
    scenario.plant.kind = robot::PlantKind::kIdeal;
    scenario.motion.interface = control::CommandInterface::kJointPosition;
    scenario.tick.generator = loop::Generator::kJoint;
    scenario.link.state.delay.law = faults::ConstantDelay{microseconds(80)};
    scenario.controller.wake_delay.law = faults::NormalDelay{microseconds(20), microseconds(4)};
    return scenario;
  }
};

TEST_P(ScenarioViabilityTest, BurstsOf19AreBridged) {
  scenario::Scenario scenario = Brisk();
  Lose(scenario, 19);
  scenario.tick.viability = 19;
  const RunResult result = Run(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_TRUE(result.report.violations.empty());
  EXPECT_GE(result.counts.held, 33U * 19U - 19U);
  EXPECT_LT(result.final_error, 1e-3);
}

TEST_P(ScenarioViabilityTest, JitterThatAbortsTheGeneratorAloneDoesNotWithTheFilter) {
  scenario::Scenario scenario = Brisk();
  scenario.controller.phase = microseconds(920);
  EXPECT_EQ(Run(scenario).report.end, backend::MotionEnd::kAborted);
  scenario.tick.viability = 19;
  const RunResult result = Run(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_LT(result.final_error, 1e-3);
}

TEST_P(ScenarioViabilityTest, ARawStreamUnderLossesIsKeptLegalToo) {
  scenario::Scenario scenario = Brisk();
  scenario.tick.generator = loop::Generator::kNone;
  Lose(scenario, 10);
  EXPECT_EQ(Run(scenario).report.end, backend::MotionEnd::kAborted);
  scenario.tick.viability = 19;
  const RunResult result = Run(scenario);
  EXPECT_TRUE(result.report.violations.empty());
  EXPECT_NE(result.report.end, backend::MotionEnd::kAborted) << result.report.failure;
}

TEST_P(ScenarioViabilityTest, VelocitiesAreKeptLegalUnderLosses) {
  scenario::Scenario scenario = Brisk();
  scenario.motion.interface = control::CommandInterface::kJointVelocity;
  scenario.tick.generator = loop::Generator::kNone;
  Lose(scenario, 19);
  scenario.tick.viability = 19;
  const RunResult result = Run(scenario);
  EXPECT_TRUE(result.report.violations.empty());
  EXPECT_NE(result.report.end, backend::MotionEnd::kAborted) << result.report.failure;
}

// Of poses the joints are kept legal as well as the filter can: src/reference/VIABILITY.md,
// "Poses".
TEST_F(ViabilityTest, TheFilterSavesMostRawStreamsOfPosesAndTheRejoiningGeneratorAll) {
  scenario::Scenario scenario = scenario::Load(models_ / "scenarios" / "cartesian.yaml");
  scenario.record = false;
  scenario.plant.kind = robot::PlantKind::kIdeal;
  for (reference::Waypoint& waypoint : scenario.motion.waypoints) waypoint.at.reset();
  scenario.motion.timing = {.velocity_scale = 0.6, .acceleration_scale = 0.5, .jerk_scale = 0.3};
  constexpr int kSeeds = 20;
  const auto aborted = [&](std::uint32_t longest) {
    int count = 0;
    for (scenario.seed = 1; scenario.seed <= kSeeds; ++scenario.seed) {
      Lose(scenario, longest);
      count += Run(scenario).report.end == backend::MotionEnd::kAborted ? 1 : 0;
    }
    return count;
  };
  scenario.tick.generator = loop::Generator::kNone;
  scenario.tick.viability.reset();
  const int unfiltered = aborted(10);
  EXPECT_GT(unfiltered, kSeeds / 2);
  scenario.tick.viability = 19;
  EXPECT_LT(aborted(10), unfiltered / 3);
  scenario.tick.generator = loop::Generator::kRejoining;
  EXPECT_EQ(aborted(19), 0);
}

TEST_P(ScenarioViabilityTest, TheRejoiningGeneratorFollowsUnderJitterAndBursts) {
  scenario::Scenario scenario = Brisk();
  scenario.controller.phase = microseconds(920);
  scenario.tick.generator = loop::Generator::kRejoining;
  scenario.tick.viability = 19;
  Lose(scenario, 19);
  const RunResult result = Run(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_LT(result.final_error, 1e-3);
}

TEST_P(ScenarioViabilityTest, WithoutLossesItNeedsNoFilterOnABriskTrajectory) {
  scenario::Scenario scenario = Brisk();
  scenario.controller.phase = microseconds(920);
  scenario.controller.clock_drift_ppm = 50;
  scenario.tick.generator = loop::Generator::kRejoining;
  const RunResult result = Run(scenario);
  EXPECT_TRUE(result.report.succeeded()) << result.report.failure;
  EXPECT_LT(result.final_error, 1e-3);
}

TEST_P(ScenarioViabilityTest, AnAdmissibleReferencePassesBitByBit) {
  for (const auto generator : {loop::Generator::kJoint, loop::Generator::kRejoining}) {
    scenario::Scenario scenario = scenario::Load(models_ / "scenarios" / "canonical.yaml");
    scenario.seed = GetParam();
    scenario.record = false;
    scenario.plant.kind = robot::PlantKind::kIdeal;
    scenario.link.command.loss = {};
    scenario.link.state.loss = {};
    scenario.tick.generator = generator;
    scenario.tick.viability.reset();
    const RunResult without = Run(scenario);
    EXPECT_FALSE(without.viability.has_value());
    scenario.tick.viability = 19;
    const RunResult with = Run(scenario);
    EXPECT_EQ(with.states_hash, without.states_hash);
    ASSERT_TRUE(with.viability.has_value());
    EXPECT_EQ(with.viability->kept_back, 0U);
    EXPECT_GT(with.viability->nearest.value().margin, 0);
  }
}

TEST_P(ScenarioViabilityTest, AdmissibleVelocitiesPassBitByBit) {
  scenario::Scenario scenario = Brisk();
  scenario.motion.interface = control::CommandInterface::kJointVelocity;
  scenario.tick.generator = loop::Generator::kNone;
  scenario.controller.wake_delay.law = faults::ConstantDelay{microseconds(20)};
  const RunResult without = Run(scenario);
  scenario.tick.viability = 19;
  const RunResult with = Run(scenario);
  EXPECT_EQ(with.states_hash, without.states_hash);
  EXPECT_EQ(with.viability.value().kept_back, 0U);
}

TEST_P(ScenarioViabilityTest, ASlowSourceIsPlayedEvenlyByTheRejoiningGenerator) {
  for (const double rate : {50.0, 125.0}) {
    scenario::Scenario scenario = Brisk();
    scenario.controller.rate_hz = rate;
    scenario.tick.generator = loop::Generator::kRejoining;
    scenario.tick.viability = 19;
    const RunResult result = Run(scenario);
    EXPECT_TRUE(result.report.succeeded()) << rate << " Hz: " << result.report.failure;
    EXPECT_LT(result.final_error, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ScenarioViabilityTest, ::testing::Range<std::uint64_t>(1, 4));

}  // namespace
}  // namespace twin::run::run_viability_test

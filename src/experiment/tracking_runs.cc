#include "experiment/tracking_runs.h"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "experiment/recording.h"
#include "experiment/runs.h"
#include "experiment/spectrum.h"
#include "twin/core/error.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {
namespace {

using scenario::Scenario;

constexpr double kFromHz = 20;  // the paper's band
constexpr double kToHz = 150;

Scenario MakeScenario(const Setting& setting, Way way, int run, const TrackingLevels& levels = {}) {
  const bool synchronous = way == Way::kSynchronous || way == Way::kQuiet;
  Scenario scenario = LoadScenario(setting, synchronous ? "synchronous" : "asynchronous");
  scenario.seed = SeedOfRun(setting, run);
  scenario.controller.phase = FromSeconds(ChoiceOfRun(setting, run) * kCycleSeconds);
  scenario.plant.kind = robot::PlantKind::kMujoco;
  scenario.plant.noise_dq = levels.noise_dq;
  scenario.tick.limiter = true;
  scenario.tick.generator = synchronous ? loop::Generator::kNone : loop::Generator::kJoint;
  scenario.tick.low_pass_hz = way == Way::kProposed ? 1000 : kLowPassHz;
  scenario.tick.finish_tolerance = 1e-2;  // behind the low-pass the end is crept up to for long
  if (levels.arrival_spread) {
    scenario.link.state.delay = {
        rt::NormalDelay{std::chrono::microseconds(120), *levels.arrival_spread}};
  }
  if (!levels.has_beat) {
    scenario.controller.clock_drift_ppm = 0;
    scenario.controller.phase = kCycle / 2;
  }
  if (way == Way::kQuiet) TakeOutTimingFaults(scenario);
  return scenario;
}

}  // namespace

reference::Trajectory TrackingPlan(const Setting& setting) {
  const Scenario scenario = MakeScenario(setting, Way::kProposed, 0);
  return run::MakeTrajectory(
      scenario,
      scenario::LoadRobotData(setting.files.models, scenario.robot.model, scenario.robot.hand));
}

TrackingOutcome MeasureTracking(const Setting& setting, const reference::Trajectory& plan, Way way,
                                int run, const TrackingLevels& levels) {
  constexpr std::size_t kRoom = 32768;  // cycles: more than the motion has
  Recording recording(kRoom);
  TrackingOutcome outcome;
  const run::RunResult result =
      RunScenario(setting, MakeScenario(setting, way, run, levels), &recording);
  outcome.succeeded = result.report.succeeded();
  const std::vector<CycleSample>& cycles = recording.cycles();
  const std::size_t end = PlannedCycles(plan, cycles);
  constexpr std::size_t kLeast = 2 * kTrackingSegment;
  if (end < kLeast) {
    throw RobotFault(
        fmt::format("a run of {} ended after {} cycles ({}); there is nothing to compare",
                    way == Way::kSynchronous || way == Way::kQuiet ? "the synchronous loop"
                                                                   : "the asynchronous loop",
                    end, result.report.failure.empty() ? "aborted" : result.report.failure));
  }
  outcome.delay_s = DelayBehind(plan, cycles, &CycleSample::q);
  outcome.rms_delayed = RmsError(plan, cycles, &CycleSample::q, outcome.delay_s);
  outcome.rms = RmsError(plan, cycles, &CycleSample::q, 0);
  auto planned = PlannedVelocities(plan);
  for (std::size_t j = 0; j < kJoints; ++j) {
    std::vector<double> dq = Signal(cycles, &CycleSample::dq, j, 0, end);
    outcome.curves.spectrum[j] = Welch(dq, 1 / kCycleSeconds, kTrackingSegment);
    outcome.band[j] = BandPower(outcome.curves.spectrum[j], kFromHz, kToHz);
    planned[j].resize(end);
    if (end > 1) outcome.slope[j] = RegressionSlope(planned[j], dq);
    outcome.curves.dq[j] = std::move(dq);
  }
  outcome.median_band =
      MedianBandPower(outcome.curves.dq[0], 1 / kCycleSeconds, kTrackingSegment, kFromHz, kToHz);
  return outcome;
}

}  // namespace twin::experiment

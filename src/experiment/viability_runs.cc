#include "experiment/viability_runs.h"

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "experiment/runs.h"
#include "experiment/tracking_figures.h"
#include "twin/reference/viability_filter.h"
#include "twin/rt/delay_model.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {
namespace {

using scenario::Scenario;

constexpr double kFromHz = 20;  // the paper's band
constexpr double kToHz = 150;
constexpr int kLongestBurst = reference::ViabilityFilter::kLostByDefault;

/// Constant ways, and of the source what an unsynchronised loop has: jitter and drift.
void DisturbTheSource(Scenario& scenario) {
  constexpr double kDriftPpm = 50;
  TakeOutTimingFaults(scenario);
  scenario.link.state.loss = {};
  scenario.link.command.loss = {};
  scenario.controller.wake_delay.law =
      rt::NormalDelay{std::chrono::microseconds(30), std::chrono::microseconds(4)};
  scenario.controller.clock_drift_ppm = kDriftPpm;
}

Scenario MakeScenario(const Setting& setting, const ViabilityCase& what, int run) {
  constexpr double kLostPercent = 0.41;
  Scenario scenario = LoadScenario(setting, "asynchronous");
  SetTempo(setting, what.tempo, scenario);
  scenario.seed = SeedOfRun(setting, run);
  if (what.disturbance != Disturbance::kCalibrated) DisturbTheSource(scenario);
  if (what.disturbance == Disturbance::kThread) {
    scenario.link.command.loss = {scenario::IndependentLoss{kLostPercent}};
  }
  // Drift carries deposits through the arrival of states in some of the runs.
  scenario.controller.phase = FromSeconds(ChoiceOfRun(setting, run) * kCycleSeconds);
  scenario.tick.limiter = what.maker != Maker::kOurs;  // as the paper runs its law
  scenario.tick.generator =
      what.maker == Maker::kOurs ? loop::Generator::kRejoining : loop::Generator::kJoint;
  if (what.maker == Maker::kOurs) scenario.tick.viability = kLongestBurst;
  return scenario;
}

void MeasureMotion(const reference::Trajectory& plan, const Recording& recording,
                   ViabilityRun& outcome) {
  const std::vector<CycleSample>& cycles = recording.cycles();
  const std::size_t end = PlannedCycles(plan, cycles);
  outcome.delay_s = DelayBehind(plan, cycles, &CycleSample::q_d);
  outcome.rms = std::ranges::max(RmsError(plan, cycles, &CycleSample::q_d, outcome.delay_s));
  for (std::size_t j = 0; j < kJoints; ++j) {
    const Spectrum spectrum =
        Welch(Signal(cycles, &CycleSample::dq_d, j, 0, end), 1 / kCycleSeconds, kTrackingSegment);
    outcome.band[j] = BandPower(spectrum, kFromHz, kToHz);
    if (j == 0) outcome.spectrum = spectrum;
  }
}

}  // namespace

ViabilityRun RunViabilityCase(const Setting& setting, const ViabilityCase& what, int run) {
  constexpr std::size_t kRoom = 32768;  // cycles: more than the motion has
  Scenario scenario = MakeScenario(setting, what, run);
  const reference::Trajectory plan = run::MakeTrajectory(
      scenario,
      scenario::LoadRobotData(setting.files.models, scenario.robot.model, scenario.robot.hand));
  if (what.disturbance == Disturbance::kBursts) {
    scenario.link.command.loss =
        LossOf(setting, {.length = kLongestBurst}, ToSeconds(plan.duration()), run);
  }
  Recording recording(kRoom);
  const run::RunResult result = RunScenario(setting, scenario, &recording);
  ViabilityRun outcome{.aborted = result.report.end == backend::MotionEnd::kAborted,
                       .succeeded = result.report.succeeded(),
                       .spectrum = {},
                       .ticks = recording.ticks()};
  if (result.viability) {
    outcome.idle_percent = 100 - result.viability->kept_back_percent();
    if (result.viability->nearest) outcome.least_margin = result.viability->nearest->margin;
  }
  MeasureMotion(plan, recording, outcome);
  return outcome;
}

}  // namespace twin::experiment

#include "experiment/viability.h"

#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "experiment/studies.h"
#include "twin/reference/viability_filter.h"

namespace twin::experiment {
namespace {

constexpr int kLongestBurst = reference::ViabilityFilter::kLostByDefault;

/// Disturbance of a motion.
struct Disturbance {
  std::string_view name;
  bool is_calibrated;  ///< the calibrated asynchronous loop; else 4 us of jitter, 50 ppm of drift
  bool has_bursts;     ///< 19 lost commands in a row, two such bursts a second
};
constexpr std::array kDisturbances{
    Disturbance{"4 us jitter, 50 ppm, 0.41 % lost", false, false},
    Disturbance{"4 us jitter, 50 ppm, bursts of 19", false, true},
    Disturbance{"calibrated loop", true, false},
};

/// One motion, on the ideal plant: behind the rejoining generator and the viability filter (ours),
/// or behind the paper's generator with lambda = 1e-3 and the client's limiter.
struct ViabilityRun {
  bool aborted = false;
  double idle_percent = 0;  ///< of the commands: those that the filter let pass; ours only
  double least_margin = 0;  ///< of the state; ours only
  double delay_s = 0;       ///< of q_d behind the plan
  double rms = 0;           ///< error of q_d, less that delay: worst joint, rad
  JointVector band{};       ///< power of dq_d in the paper's band, (rad/s)^2
  Spectrum spectrum{};      ///< of dq_d, joint 1
  std::vector<TickSample> ticks{};
};

/// Constant delays, and the jitter and drift of an unsynchronised source.
void SetSourceFaults(scenario::Scenario& scenario) {
  RemoveTimingFaults(scenario);
  scenario.link.state.loss = {};
  scenario.link.command.loss = {};
  scenario.controller.wake_delay.law =
      faults::NormalDelay{std::chrono::microseconds(30), std::chrono::microseconds(4)};
  scenario.controller.clock_drift_ppm = 50;
}

scenario::Scenario ViabilityScenario(const Config& config, const Pace& pace,
                                     const Disturbance& disturbance, bool is_ours, int run) {
  scenario::Scenario scenario = LoadScenario(config, "asynchronous", run);
  SetPace(config, pace, scenario);
  if (!disturbance.is_calibrated) SetSourceFaults(scenario);
  if (!disturbance.is_calibrated && !disturbance.has_bursts) {
    scenario.link.command.loss = {scenario::IndependentLoss{0.41}};
  }
  // Drift carries deposits through the arrival of states in some of the runs.
  scenario.controller.phase = PhaseOfRun(config, run);
  scenario.tick.limiter = !is_ours;  // as the paper runs its law
  scenario.tick.generator = is_ours ? loop::Generator::kRejoining : loop::Generator::kJoint;
  if (is_ours) scenario.tick.viability = kLongestBurst;
  return scenario;
}

/// @param run  gives seed and start phase, the same for both. @throws as RunScenario.
ViabilityRun MeasureViability(const Config& config, const Pace& pace,
                              const Disturbance& disturbance, bool is_ours, int run) {
  scenario::Scenario scenario = ViabilityScenario(config, pace, disturbance, is_ours, run);
  const reference::Trajectory plan = PlanOf(config, scenario);
  if (disturbance.has_bursts) {
    scenario.link.command.loss = LossOf(config, {.length = kLongestBurst}, plan.duration(), run);
  }
  Recording recording;
  const run::RunResult result = RunScenario(config, scenario, &recording);
  ViabilityRun outcome{.aborted = result.report.end == backend::MotionEnd::kAborted,
                       .ticks = recording.ticks()};
  if (result.viability) {
    outcome.idle_percent = 100 - result.viability->kept_back_percent();
    if (result.viability->nearest) outcome.least_margin = result.viability->nearest->margin;
  }
  const std::vector<CycleSample>& cycles = recording.cycles();
  const std::size_t end = PlannedCycles(plan, cycles);
  outcome.delay_s = DelayBehind(plan, cycles, &CycleSample::q_d);
  outcome.rms = std::ranges::max(RmsError(plan, cycles, &CycleSample::q_d, outcome.delay_s));
  for (std::size_t j = 0; j < kJoints; ++j) {
    const Spectrum spectrum = Welch(Signal(cycles, &CycleSample::dq_d, j, 0, end));
    outcome.band[j] = BandPower(spectrum);
    if (j == 0) outcome.spectrum = spectrum;
  }
  return outcome;
}

/// The runs of one pace and one disturbance.
struct GeneratorPair {
  Pace pace;
  Disturbance disturbance;
  std::span<const ViabilityRun> ours;
  std::span<const ViabilityRun> paper;
};

double AbortedPercent(std::span<const ViabilityRun> runs) {
  const auto aborted = std::ranges::count_if(runs, &ViabilityRun::aborted);
  return 100.0 * static_cast<double>(aborted) / static_cast<double>(runs.size());
}

/// Our power in the band over that of the paper's generator in the same runs, of those that the
/// latter completes: worst joint. NaN without such runs.
double BandRatio(const GeneratorPair& pair) {
  double worst = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t j = 0; j < kJoints; ++j) {
    double ours = 0;
    double paper = 0;
    for (std::size_t run = 0; run < pair.paper.size(); ++run) {
      if (pair.paper[run].aborted) continue;
      ours += pair.ours[run].band[j];
      paper += pair.paper[run].band[j];
    }
    if (paper > 0) worst = std::fmax(worst, ours / paper);
  }
  return worst;
}

void ComparePair(const GeneratorPair& pair, Findings& findings) {
  const std::string name = fmt::format("{}, {}: ", pair.pace.name, pair.disturbance.name);
  const double aborted = AbortedPercent(pair.ours);
  findings.Add(name + "ours aborted", "%", aborted).Demand("none", aborted == 0);
  findings.Add(name + "the paper's generator aborted", "%", AbortedPercent(pair.paper));
  // Bursts are no admissible reference, and a source near its limits leaves no room to rejoin.
  const bool is_smooth = pair.pace.stretch == 0 && !pair.disturbance.has_bursts;
  // The worst of the runs, with the range.
  const auto add = [&](const char* quantity, const char* unit, bool largest,
                       double ViabilityRun::*field, double factor) -> Comparison& {
    Spread spread = SpreadOf(
        ValuesOf(pair.ours, [&](const ViabilityRun& run) { return factor * (run.*field); }));
    spread.mean = largest ? spread.high : spread.low;
    return findings.Add(name + quantity, unit, spread);
  };
  Comparison& idle =
      add("commands that the filter let pass", "%", false, &ViabilityRun::idle_percent, 1);
  idle.Demand(is_smooth ? "at least 99 in every run" : "", idle.ours >= 99);
  Comparison& rms =
      add("RMS error less its delay, worst joint", "mrad", true, &ViabilityRun::rms, 1e3);
  rms.Demand(is_smooth ? "at most 2 in every run" : "", rms.ours <= 2);
  add("delay", "ms", true, &ViabilityRun::delay_s, 1e3);
  add("least margin", "", false, &ViabilityRun::least_margin, 1);
  const double ratio = BandRatio(pair);
  findings
      .Add(name + "power of dq_d in 20 to 150 Hz over that of the paper's generator, worst joint",
           "", ratio)
      .Demand(is_smooth && !std::isnan(ratio) ? "at most 2" : "", ratio <= 2);
}

/// The least of the joints' margins over a trajectory under bursts, at each pace.
Figure MarginFigure(const std::vector<GeneratorPair>& pairs) {
  constexpr std::size_t kEvery = 5;
  Figure figure{.id = "margin",
                .columns = "stretch of the brisk trajectory [-],t [s],margin [-],kept back [bits]"};
  for (const GeneratorPair& pair : pairs) {
    if (!pair.disturbance.has_bursts) continue;
    figure.names.emplace_back(pair.pace.name);
    const std::vector<TickSample>& ticks = pair.ours.front().ticks;
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      const TickSample& tick = ticks[k];
      if (k % kEvery != 0 && tick.kept_back == 0) continue;
      const auto cycle = static_cast<double>(tick.message_id - ticks.front().message_id);
      figure.rows.push_back(
          Row(pair.pace.stretch, cycle * kCycleSeconds, tick.margin.value_or(0), tick.kept_back));
    }
  }
  return figure;
}

Figure SpectrumFigure(const GeneratorPair& pair) {
  const Spectrum& ours = pair.ours.front().spectrum;
  const Spectrum& paper = pair.paper.front().spectrum;
  return FigureOf(
      "spectrum",
      {{"f [Hz]", Steps(std::min(ours.density.size(), paper.density.size()), ours.step_hz)},
       {"ours [(rad/s)^2/Hz]", ours.density},
       {"the paper's generator [(rad/s)^2/Hz]", paper.density}},
      1);
}

}  // namespace

Findings RunViability(const Config& config) {
  const int runs = std::min(config.seeds, 6);
  const scenario::RobotData robot = RobotOf(config, LoadScenario(config, "asynchronous"));
  Findings findings{.values = {{"runs", fmt::format("{}", runs)}}};
  std::vector<reference::AxisBounds> bounds;
  for (std::size_t i = 0; i < kJoints; ++i) {
    bounds.push_back(reference::BoundsOf(robot.limits, i));
  }
  AddViableSet(bounds, findings);
  AddConvergence(robot, findings);
  AddHostileSource(robot, findings);
  if (config.progress) config.progress(0.3);
  const Grid<ViabilityRun> all = MapGrid(
      PartOf(config, 0.3, 1), kPaces.size() * kDisturbances.size(), 2 * runs,
      [&](std::size_t pair, std::size_t i) {
        const int run = static_cast<int>(i);
        return MeasureViability(config, kPaces[pair / kDisturbances.size()],
                                kDisturbances[pair % kDisturbances.size()], run < runs, run % runs);
      });
  std::vector<GeneratorPair> pairs;
  for (std::size_t i = 0; i < all.rows(); ++i) {
    pairs.push_back({kPaces[i / kDisturbances.size()], kDisturbances[i % kDisturbances.size()],
                     all[i].first(runs), all[i].subspan(runs)});
    ComparePair(pairs.back(), findings);
  }
  findings.figures.push_back(SpectrumFigure(pairs.front()));
  findings.figures.push_back(MarginFigure(pairs));
  return findings;
}

}  // namespace twin::experiment

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "experiment/tracking.h"
#include "twin/core/error.h"
#include "twin/reference/low_pass.h"

namespace twin::experiment {
namespace {

bool IsSynchronous(Setup setup) {
  return setup == Setup::kSynchronous || setup == Setup::kQuiet;
}

scenario::Scenario TrackingScenario(const Config& config, Setup setup, int run,
                                    const TrackingLevels& levels) {
  const bool synchronous = IsSynchronous(setup);
  scenario::Scenario scenario =
      LoadScenario(config, synchronous ? "synchronous" : "asynchronous", run);
  scenario.controller.phase = PhaseOfRun(config, run);
  scenario.plant.kind = robot::PlantKind::kMujoco;
  scenario.plant.noise_dq = levels.noise_dq;
  scenario.tick.limiter = true;
  scenario.tick.generator = synchronous ? loop::Generator::kNone : loop::Generator::kJoint;
  scenario.tick.low_pass_hz = setup == Setup::kProposed ? 1000 : kLowPassHz;
  scenario.tick.finish_tolerance = 1e-2;  // behind the low-pass the end takes long
  if (levels.arrival_spread) {
    scenario.link.state.delay = {
        faults::NormalDelay{std::chrono::microseconds(120), *levels.arrival_spread}};
  }
  if (!levels.has_beat) {
    scenario.controller.clock_drift_ppm = 0;
    scenario.controller.phase = kCycle / 2;
  }
  if (setup == Setup::kQuiet) RemoveTimingFaults(scenario);
  return scenario;
}

constexpr std::array<double, kJoints> kFrequencies{0.05, 0.1, 0.2, 0.5, 1, 2, 5};
constexpr JointVector kMiddle{0, -0.5, 0, -2, 0, 1.6, 0.7};
/// At most 0.5 rad/s and 1 rad/s^2: within the reference generator's guarantee.
constexpr JointVector kAmplitudes{0.5, 0.5, 0.3, 0.1, 0.025, 0.006, 0.001};
constexpr double kLengthS = 40;
constexpr double kRampS = 3;
/// The compared part: whole periods of all sines, after 17 s, six of the longest time constant.
constexpr double kFromS = 17;
constexpr double kToS = 37;

std::vector<reference::Waypoint> Swings() {
  constexpr int kStepMs = 10;
  std::vector<reference::Waypoint> waypoints;
  for (int ms = 0; ms <= static_cast<int>(kLengthS * 1000); ms += kStepMs) {
    const double t = ms * 1e-3;
    const double share = SmoothStep(t / kRampS) * SmoothStep((kLengthS - t) / kRampS);
    reference::Waypoint point{.q = kMiddle, .at = std::chrono::milliseconds(ms)};
    for (std::size_t j = 0; j < kJoints; ++j) {
      point.q[j] += kAmplitudes[j] * share * std::sin(2 * std::numbers::pi * kFrequencies[j] * t);
    }
    waypoints.push_back(point);
  }
  return waypoints;
}

/// The deposited velocity behind each cycle's command; held where a cycle has none.
std::vector<JointVector> VelocitiesInUse(const Recording& recording) {
  std::vector<JointVector> values;
  std::size_t next = 0;
  JointVector newest{};
  for (const CycleSample& cycle : recording.cycles()) {
    while (next < recording.ticks().size() &&
           recording.ticks()[next].message_id < cycle.message_id) {
      newest = recording.ticks()[next++].dq_ext;
    }
    values.push_back(newest);
  }
  return values;
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPaperRatio = 10;

/// Ratios at the levels tried; NaN where a run did not reach its goal.
struct LevelCurve {
  std::vector<double> x;
  TrackingLevels (*levels)(double x);
  std::vector<double> ratio{};
};

/// Power of joint 1 in the band; NaN when the robot ended the motion.
double PowerOf(const Config& config, const reference::Trajectory& plan, Setup setup,
               const TrackingLevels& levels) {
  try {
    const TrackingOutcome outcome = MeasureTracking(config, plan, setup, 0, levels);
    return outcome.succeeded ? outcome.band[0] : kNaN;
  } catch (const RobotFault&) {
    ThrowIfInterrupted(config);
    return kNaN;
  }
}

/// The level at which the ratio first is the paper's, interpolated by both logarithms.
double FirstAtPapersRatio(const LevelCurve& curve) {
  for (std::size_t i = 1; i < curve.x.size(); ++i) {
    const double a = curve.ratio[i - 1];
    const double b = curve.ratio[i];
    if (!(std::min(a, b) < kPaperRatio && std::max(a, b) >= kPaperRatio)) continue;
    const double share = std::log(kPaperRatio / a) / std::log(b / a);
    return curve.x[i - 1] * std::pow(curve.x[i] / curve.x[i - 1], share);
  }
  return kNaN;
}

/// The same of noise, which both loops have: ratio - 1 goes with 1 / noise^2. From the last level
/// at which both reached their goal.
double NoiseAtPapersRatio(const LevelCurve& noise, double& last) {
  double at = kNaN;
  for (std::size_t i = 0; i < noise.x.size(); ++i) {
    if (!std::isfinite(noise.ratio[i])) break;
    last = noise.x[i];
    at = last * std::sqrt((noise.ratio[i] - 1) / (kPaperRatio - 1));
  }
  return at;
}

}  // namespace

reference::Trajectory TrackingPlan(const Config& config) {
  return PlanOf(config, TrackingScenario(config, Setup::kProposed, 0, {}));
}

TrackingOutcome MeasureTracking(const Config& config, const reference::Trajectory& plan,
                                Setup setup, int run, const TrackingLevels& levels) {
  Recording recording;
  const run::RunResult result =
      RunScenario(config, TrackingScenario(config, setup, run, levels), &recording);
  TrackingOutcome outcome{.succeeded = result.report.succeeded()};
  const std::vector<CycleSample>& cycles = recording.cycles();
  const std::size_t end = PlannedCycles(plan, cycles);
  if (end < 2 * kSpectrumSegment) {
    throw RobotFault(
        fmt::format("a run of the {} loop ended after {} cycles ({}), too early for a comparison",
                    IsSynchronous(setup) ? "synchronous" : "asynchronous", end,
                    result.report.failure.empty() ? "aborted" : result.report.failure));
  }
  outcome.delay_s = DelayBehind(plan, cycles, &CycleSample::q);
  outcome.rms_delayed = RmsError(plan, cycles, &CycleSample::q, outcome.delay_s);
  outcome.rms = RmsError(plan, cycles, &CycleSample::q, 0);
  auto planned = PlannedVelocities(plan);
  for (std::size_t j = 0; j < kJoints; ++j) {
    std::vector<double> dq = Signal(cycles, &CycleSample::dq, j, 0, end);
    outcome.spectrum[j] = Welch(dq);
    outcome.band[j] = BandPower(outcome.spectrum[j]);
    planned[j].resize(end);
    outcome.slope[j] = RegressionSlope(planned[j], dq);
    outcome.dq[j] = std::move(dq);
  }
  outcome.median_band = MedianBandPower(outcome.dq[0]);
  return outcome;
}

double FollowedShare::largest_error() const noexcept {
  double largest = 0;
  for (std::size_t j = 0; j < kJoints; ++j) {
    largest = std::max(largest, std::abs(measured[j] - expected[j]) / std::abs(expected[j]));
  }
  return largest;
}

std::complex<double> LowPassedResponse(double gain, double lambda, double frequency_hz) noexcept {
  const std::complex<double> s{0, 2 * std::numbers::pi * frequency_hz};
  const double rate = lambda / kCycleSeconds;
  return gain * (s + rate) / (s + gain * rate);
}

FollowedShare MeasureFollowedShare(const Config& config, double low_pass_hz) {
  scenario::Scenario scenario = LoadScenario(config, "asynchronous");
  scenario.tick.low_pass_hz = low_pass_hz;
  scenario.tick.finish_tolerance = 1e-2;
  scenario.motion.waypoints = Swings();
  scenario.motion.timing = {};
  Recording recording;
  RunScenario(config, scenario, &recording);
  const std::vector<JointVector> in_use = VelocitiesInUse(recording);
  FollowedShare share{.frequency_hz = kFrequencies};
  const auto cycle = [](double seconds) {
    return static_cast<std::size_t>(seconds / kCycleSeconds);
  };
  const double gain = reference::LowPass(low_pass_hz).gain();
  for (std::size_t j = 0; j < kJoints; ++j) {
    share.expected[j] = LowPassedResponse(gain, scenario.tick.lambda, kFrequencies[j]);
    if (in_use.size() < cycle(kToS)) continue;  // it ended early: nothing was followed
    std::vector<double> deposited;
    for (std::size_t k = cycle(kFromS); k < cycle(kToS); ++k) deposited.push_back(in_use[k][j]);
    const std::vector<double> followed =
        Signal(recording.cycles(), &CycleSample::dq_d, j, cycle(kFromS), cycle(kToS));
    share.measured[j] =
        SineAmplitude(followed, kFrequencies[j]) / SineAmplitude(deposited, kFrequencies[j]);
  }
  return share;
}

void AddLevels(const Config& config, const reference::Trajectory& plan, Findings& findings) {
  const std::vector<double> spreads{0.3, 1, 3, 6, 10, 30};  // us
  std::array<LevelCurve, 3> curves{
      {{{1, 4, 8, 12}, [](double mrad_s) { return TrackingLevels{.noise_dq = 1e-3 * mrad_s}; }},
       {spreads,
        [](double us) { return TrackingLevels{.arrival_spread = FromSeconds(1e-6 * us)}; }},
       {spreads, [](double us) {
          return TrackingLevels{.arrival_spread = FromSeconds(1e-6 * us), .has_beat = false};
        }}}};
  auto& [noise, beat, one_clock] = curves;
  std::vector<std::pair<Setup, TrackingLevels>> runs;
  for (const double x : noise.x) runs.emplace_back(Setup::kProposed, noise.levels(x));
  for (const LevelCurve& curve : curves) {
    for (const double x : curve.x) runs.emplace_back(Setup::kSynchronous, curve.levels(x));
  }
  const std::vector<double> powers = MapInParallel(config, runs.size(), [&](int i) {
    return PowerOf(config, plan, runs[i].first, runs[i].second);
  });
  Figure figure{.id = "levels",
                .columns =
                    "varied: 0 noise [mrad/s]; 1 spread with a beat [us]; 2 spread without "
                    "[us],value,ratio"};
  std::size_t next = noise.x.size();
  for (std::size_t kind = 0; kind < curves.size(); ++kind) {
    for (std::size_t i = 0; i < curves[kind].x.size(); ++i) {
      // The noise is that of both loops.
      const double ratio = powers[next++] / powers[kind == 0 ? i : 0];
      curves[kind].ratio.push_back(ratio);
      figure.rows.push_back(Row(kind, curves[kind].x[i], ratio));
    }
  }
  double most = 0;
  const double at = NoiseAtPapersRatio(noise, most);
  findings.Add("Noise of dq at which the ratio of joint 1 would be 10, by 1 / noise^2", "mrad/s",
               at);
  findings.Add("Largest noise of dq tried at which both loops reach the goal", "mrad/s", most);
  findings.Add("Spread of the states' arrival at which the ratio would be 10, no beat", "us",
               FirstAtPapersRatio(one_clock));
  findings.Add("The same with the beat, where it jumps", "us", FirstAtPapersRatio(beat));
  findings.figures.push_back(std::move(figure));
}

}  // namespace twin::experiment

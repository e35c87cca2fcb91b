#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "experiment/studies.h"
#include "experiment/wave_source.h"
#include "twin/control/registry.h"
#include "twin/reference/moving_average.h"

namespace twin::experiment {
namespace {

using control::CommandInterface;

constexpr double kOmega = std::numbers::pi / 2;  // of the wave, rad/s
constexpr double kPaperRateHz = 125;
constexpr std::array<double, 6> kRatesHz{1000, 500, 250, 125, 100, 62.5};

struct NamedInterface {
  CommandInterface interface;
  const char* name;
  JointVector CycleSample::*answer;  ///< signal of the robot's state that follows it
};
constexpr std::array<NamedInterface, 3> kInterfaces{
    {{CommandInterface::kJointPosition, "position", &CycleSample::q_d},
     {CommandInterface::kJointVelocity, "velocity", &CycleSample::dq_d},
     {CommandInterface::kTorque, "torque", &CycleSample::tau_J_d}}};

/// A source of one rate on one interface, the stage off and on.
struct StagePair {
  Recording off;
  Recording on;
  bool ended_well = false;
};

/// Joint 1 swings, the others stand. Behind a source of `rate_hz` an update makes a jerk of N ddq/T
/// when nothing spreads it: the swing keeps that to 0.4 of the jerk limit of joint 1, so that an
/// update of double size, or one held over a lost cycle, stays within.
double LargestAcceleration(double rate_hz) {
  constexpr double kShare = 0.4;
  constexpr double kJerkLimit = 7500;  // rad/s^3; models/robots/panda/limits.yaml
  constexpr double kGentle = 1;        // rad/s^2
  const double N = static_cast<double>(reference::RateMatchingWindow(rate_hz));
  return std::min(kGentle, kShare * kJerkLimit * kCycleSeconds / N);
}

/// The asynchronous loop with a source of `rate_hz`, and every state in time: a cycle that goes
/// unserved would shape the commands, too.
scenario::Scenario RateScenario(const Config& config, CommandInterface interface, double rate_hz,
                                bool stage) {
  scenario::Scenario scenario = LoadScenario(config, "asynchronous");
  scenario.motion.interface = interface;
  scenario.tick.generator = interface == CommandInterface::kJointPosition ? loop::Generator::kJoint
                                                                          : loop::Generator::kNone;
  scenario.tick.rate_matching = stage;
  scenario.tick.limiter = false;
  scenario.tick.finish_tolerance = 1e-2;
  scenario.controller.rate_hz = rate_hz;
  scenario.link.state.delay = ConstantDelay(100);
  return scenario;
}

StagePair MeasureStage(const Config& config, CommandInterface interface, double rate_hz) {
  scenario::Scenario scenario = RateScenario(config, interface, rate_hz, false);
  const JointVector q = scenario.motion.waypoints.front().q;
  scenario.motion.waypoints = {{.q = q, .at = Duration{}}, {.q = q, .at = WaveSource::kLength}};
  scenario.motion.timing = {};
  control::ControllerRegistry controllers;
  controllers.Add(scenario.controller.type, [&](const control::ControllerRequest& request) {
    return std::make_unique<WaveSource>(request.interface, request.trajectory.start(),
                                        LargestAcceleration(rate_hz));
  });
  const run::Catalogue catalogue{config.catalogue.get().backends, controllers};
  Config with_wave = config;
  with_wave.catalogue = catalogue;
  StagePair pair;
  const bool off = RunScenario(with_wave, scenario, &pair.off).report.succeeded();
  scenario.tick.rate_matching = true;
  const bool on = RunScenario(with_wave, scenario, &pair.on).report.succeeded();
  pair.ended_well = off && on;
  return pair;
}

/// Delay of `on` behind `off`: the difference of their lags behind the wave by least squares.
double DelayOf(const StagePair& pair, const NamedInterface& interface, double acceleration) {
  const auto delay = [&](const Recording& recording) {
    return WaveDelay(interface.interface, acceleration,
                     Signal(recording.cycles(), interface.answer, 0));
  };
  return delay(pair.on) - delay(pair.off);
}

/// Command of joint 1 of each tick, by the state it answers.
std::vector<double> Commands(const Recording& recording) {
  std::vector<double> commands;
  for (const TickSample& tick : recording.ticks()) {
    while (!commands.empty() &&
           recording.ticks().front().message_id + commands.size() < tick.message_id) {
      commands.push_back(std::nan(""));  // this state has no answer
    }
    commands.push_back(tick.dq_c[0]);
  }
  return commands;
}

/// Riser of each update with the stage off, over the increment per cycle with the stage on; of
/// updates that lasted N cycles and exceed `least`. @returns their median.
double RiserRatio(const StagePair& pair, std::size_t N, double least) {
  const std::vector<double> off = Commands(pair.off);
  const std::vector<double> on = Commands(pair.on);
  std::vector<double> ratios;
  const std::size_t end = std::min(off.size(), on.size());
  for (std::size_t k = 1; k + N < end; ++k) {
    const double riser = off[k] - off[k - 1];
    const double increment = on[k + N / 2] - on[k + N / 2 - 1];
    if (std::abs(riser) > least && std::isfinite(increment)) {
      ratios.push_back(riser / increment);
    }
  }
  return UpperMedian(std::move(ratios));
}

double PaperRiserRatio(const StagePair& pair) {
  const std::size_t N = reference::RateMatchingWindow(kPaperRateHz);
  const double least =
      0.2 * static_cast<double>(N) * LargestAcceleration(kPaperRateHz) * kCycleSeconds;
  return RiserRatio(pair, N, least);
}

/// The paper's figure: commanded velocity of joint 1, and its increment per cycle.
Figure UpdatesFigure(const StagePair& pair) {
  std::vector<double> off = Commands(pair.off);
  std::vector<double> on = Commands(pair.on);
  off.resize(std::min(off.size(), on.size()));
  const auto increments = [](std::vector<double> values) {
    std::adjacent_difference(values.begin(), values.end(), values.begin());
    return values;
  };
  return FigureOf("updates",
                  {{"t [s]", Steps(off.size())},
                   {"off [rad/s]", off},
                   {"on [rad/s]", on},
                   {"increment off [rad/s]", increments(off)},
                   {"increment on [rad/s]", increments(on)}},
                  1);
}

bool IsPapers(double rate_hz, const NamedInterface& interface) {
  return rate_hz == kPaperRateHz && interface.interface == CommandInterface::kJointVelocity;
}

/// The delay of the stage at all rates on all interfaces, and what the paper shows.
void AddRates(const Config& config, Findings& findings) {
  constexpr double kTolerance = 0.1;
  StagePair paper;
  std::atomic<int> failed_runs{0};
  const Grid<double> delays =
      MapGrid(config, kRatesHz.size(), kInterfaces.size(), [&](std::size_t rate, std::size_t i) {
        StagePair pair = MeasureStage(config, kInterfaces[i].interface, kRatesHz[rate]);
        failed_runs += pair.ended_well ? 0 : 1;
        const double delay_s = DelayOf(pair, kInterfaces[i], LargestAcceleration(kRatesHz[rate]));
        if (IsPapers(kRatesHz[rate], kInterfaces[i])) paper = std::move(pair);
        return delay_s;
      });
  const auto paper_N = static_cast<double>(reference::RateMatchingWindow(kPaperRateHz));
  const double ratio = PaperRiserRatio(paper);
  findings.Add("125 Hz, velocity: riser of an update over the increment of a cycle", "", ratio)
      .Paper(paper_N)
      .Demand("8 within 0.1", std::abs(ratio - paper_N) <= kTolerance);
  Figure figure{.id = "delays",
                .columns = "source [Hz],N,formula [ms],position [ms],velocity [ms],torque [ms]"};
  for (std::size_t rate = 0; rate < kRatesHz.size(); ++rate) {
    const auto N = static_cast<double>(reference::RateMatchingWindow(kRatesHz[rate]));
    const double formula_ms = (N - 1) / 2 * kCycleSeconds * 1e3;
    std::vector<double>& row = figure.rows.emplace_back(std::vector{kRatesHz[rate], N, formula_ms});
    for (std::size_t i = 0; i < kInterfaces.size(); ++i) {
      const double delay_ms = row.emplace_back(1e3 * delays[rate][i]);
      Comparison& one = findings.Add(
          fmt::format("{:g} Hz, {}: delay, stage on less off", kRatesHz[rate], kInterfaces[i].name),
          "ms", delay_ms);
      if (N > 1) {  // a window of one does nothing
        one.Demand(fmt::format("{:g} ms within 0.1 ms", formula_ms),
                   std::abs(delay_ms - formula_ms) <= kTolerance);
      }
      if (IsPapers(kRatesHz[rate], kInterfaces[i])) one.Paper(3.5);
    }
  }
  findings.Add("Runs that did not end well", "", failed_runs).Demand("none", failed_runs == 0);
  findings.figures = {UpdatesFigure(paper), std::move(figure)};
}

constexpr std::size_t kEnvelopeWindow = 250;  // cycles of an envelope's point
constexpr double kMostDifference = 0.05;      // of a joint's largest speed
constexpr const char* kRates = "125 Hz, velocity, canonical trajectory";

/// The canonical trajectory from a velocity source at 125 Hz. @returns whether it reached its goal.
bool RunCanonicalVelocities(const Config& config, bool stage, bool limiter, Recording& recording) {
  scenario::Scenario scenario =
      RateScenario(config, CommandInterface::kJointVelocity, kPaperRateHz, stage);
  scenario.tick.limiter = limiter;
  return RunScenario(config, scenario, &recording).report.succeeded();
}

/// Largest magnitude in each window.
std::vector<double> EnvelopeOf(const std::vector<double>& signal) {
  std::vector<double> envelope;
  for (std::size_t begin = 0; begin < signal.size(); begin += kEnvelopeWindow) {
    double most = 0;
    for (std::size_t k = begin; k < std::min(begin + kEnvelopeWindow, signal.size()); ++k) {
      most = std::max(most, std::abs(signal[k]));
    }
    envelope.push_back(most);
  }
  return envelope;
}

/// Largest difference of two envelopes, as a share of the largest value of the first.
double EnvelopeDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    most = std::max(most, std::abs(a[i] - b[i]));
    largest = std::max(largest, a[i]);
  }
  return largest > 0 ? most / largest : 0;
}

std::vector<double> VelocityOf(const Recording& recording, std::size_t joint) {
  return Signal(recording.cycles(), &CycleSample::dq_d, joint);
}

Figure EnvelopesFigure(const Recording& off, const Recording& on) {
  const std::size_t cycles = std::min(off.cycles().size(), on.cycles().size());
  std::vector<Column> columns{{"t [s]", Steps(cycles)}};
  for (std::size_t j = 0; j < kJoints; ++j) {
    columns.push_back({fmt::format("off_{} [rad/s]", j + 1), VelocityOf(off, j)});
    columns.push_back({fmt::format("on_{} [rad/s]", j + 1), VelocityOf(on, j)});
  }
  return FigureOf("envelopes", columns, 0, 4);
}

/// The canonical trajectory from a velocity source at 125 Hz, rate matching off and on, rate
/// limiter on in both: whether the envelopes of the commands coincide, as in the paper's figure.
void AddEnvelopes(const Config& config, Findings& findings) {
  std::array<Recording, 3> recordings;  // off, on, unlimited
  std::array<bool, 3> ended_well{};
  InParallel(config, 3, [&](int i) {
    ended_well[i] = RunCanonicalVelocities(config, i == 1, i != 2, recordings[i]);
  });
  const auto& [off, on, unlimited] = recordings;
  double most = 0;
  for (std::size_t j = 0; j < kJoints; ++j) {
    most = std::max(
        most, EnvelopeDifference(EnvelopeOf(VelocityOf(off, j)), EnvelopeOf(VelocityOf(on, j))));
  }
  findings
      .Add(fmt::format("{}: envelopes off and on apart, the most of any joint", kRates), "%",
           100 * most)
      .Demand(fmt::format("at most {:g} % of the joint's largest speed, and both reach the goal",
                          100 * kMostDifference),
              ended_well[0] && ended_well[1] && most <= kMostDifference);
  findings.Add(fmt::format("{}, stage and rate limiter off: aborts", kRates), "%",
               ended_well[2] ? 0.0 : 100.0);
  findings.figures.push_back(EnvelopesFigure(off, on));
}

}  // namespace

WaveValue WaveAt(control::CommandInterface interface, double acceleration, double t) noexcept {
  const double length_s = ToSeconds(WaveSource::kLength);
  if (t <= 0 || t >= length_s) return {};
  // sin^4(x) = (3 - 4 cos 2x + cos 4x) / 8
  const double x = kOmega * t;
  const double amplitude = acceleration / (4 * kOmega * kOmega);
  const double q = amplitude * (3 - 4 * std::cos(2 * x) + std::cos(4 * x)) / 8;
  const double dq = amplitude * kOmega * (std::sin(2 * x) - std::sin(4 * x) / 2);
  const double ddq = acceleration * (std::cos(2 * x) - std::cos(4 * x)) / 2;
  if (interface == control::CommandInterface::kJointVelocity) return {dq, ddq};
  return {q, dq};
}

void WaveSource::Update(const RobotState& /*state*/, Time now,
                        control::ControllerOutput& output) noexcept {
  if (!is_running_) {
    is_running_ = true;
    begin_ = now;
  }
  const double t = ToSeconds(now - begin_);
  output.target.joint = {.q = start_};
  output.target.tau_J_d = {};
  const double value = WaveAt(interface_, acceleration_, t).value;
  switch (interface_) {
    case control::CommandInterface::kJointVelocity: output.target.joint.dq[0] = value; break;
    case control::CommandInterface::kTorque: output.target.tau_J_d[0] = value; break;
    default: output.target.joint.q[0] += value; break;
  }
  output.has_velocity = interface_ == control::CommandInterface::kJointVelocity;
  output.finished = now - begin_ >= kLength;
}

double WaveDelay(control::CommandInterface interface, double acceleration,
                 const std::vector<double>& signal) {
  const auto count = static_cast<double>(signal.size());
  return LeastSquaresDelay(5, [&](double delay_s) {
    double error = 0;
    double rate = 0;
    DelaySums sums;
    for (std::size_t k = 0; k < signal.size(); ++k) {
      const WaveValue wave =
          WaveAt(interface, acceleration, static_cast<double>(k) * kCycleSeconds - delay_s);
      error += wave.value - signal[k];
      rate += wave.rate;
      sums.product += (wave.value - signal[k]) * wave.rate;
      sums.square += wave.rate * wave.rate;
    }
    sums.product -= error * rate / count;
    sums.square -= rate * rate / count;
    return sums;
  });
}

Findings RunRateMatchingOnWallClock(const Config& config) {
  const StagePair pair = MeasureStage(config, CommandInterface::kJointVelocity, kPaperRateHz);
  Findings findings;
  findings
      .Add("125 Hz, velocity: riser of an update over the increment of a cycle", "",
           PaperRiserRatio(pair))
      .Paper(static_cast<double>(reference::RateMatchingWindow(kPaperRateHz)));
  findings.Add("Both runs ended well", "%", pair.ended_well ? 100.0 : 0.0);
  findings.figures = {UpdatesFigure(pair)};
  return findings;
}

Findings RunRateMatching(const Config& config) {
  Findings findings;
  AddRates(config, findings);
  AddEnvelopes(config, findings);
  return findings;
}

}  // namespace twin::experiment

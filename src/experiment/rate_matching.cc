#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "experiment/statistics.h"
#include "experiment/studies.h"
#include "experiment/wave_source.h"
#include "twin/control/registry.h"
#include "twin/reference/moving_average.h"

namespace twin::experiment {
namespace {

using control::CommandInterface;

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
  control::ControllerRegistry controllers;
  const double acceleration = LargestAcceleration(rate_hz);
  const auto make = [acceleration](const control::ControllerRequest& request) {
    return std::make_unique<WaveSource>(request.interface, request.trajectory.start(),
                                        acceleration);
  };
  const run::Catalogue catalogue{config.catalogue.get().backends, controllers};
  Config with_wave = config;
  with_wave.catalogue = catalogue;
  const auto run = [&](bool stage, Recording& recording) {
    scenario::Scenario scenario = RateScenario(config, interface, rate_hz, stage);
    const JointVector q = scenario.motion.waypoints.front().q;
    scenario.motion.waypoints = {{.q = q, .at = Duration{}}, {.q = q, .at = WaveSource::kLength}};
    scenario.motion.timing = {};
    if (controllers.Names().empty()) controllers.Add(scenario.controller.type, make);
    return RunScenario(with_wave, scenario, &recording).report.succeeded();
  };
  StagePair pair;
  const bool off = run(false, pair.off);
  const bool on = run(true, pair.on);
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

/// All rates on all interfaces.
struct RateResults {
  Grid<double> delay_s;  ///< of each interface, a row for each rate
  int failed_runs = 0;
  StagePair paper;  ///< the paper's: 125 Hz, velocity
};

bool IsPapers(double rate_hz, const NamedInterface& interface) {
  return rate_hz == kPaperRateHz && interface.interface == CommandInterface::kJointVelocity;
}

RateResults MeasureRates(const Config& config) {
  RateResults results;
  std::atomic<int> failed{0};
  results.delay_s =
      MapGrid(config, kRatesHz.size(), kInterfaces.size(), [&](std::size_t rate, std::size_t i) {
        StagePair pair = MeasureStage(config, kInterfaces[i].interface, kRatesHz[rate]);
        failed += pair.ended_well ? 0 : 1;
        const double delay_s = DelayOf(pair, kInterfaces[i], LargestAcceleration(kRatesHz[rate]));
        if (IsPapers(kRatesHz[rate], kInterfaces[i])) results.paper = std::move(pair);
        return delay_s;
      });
  results.failed_runs = failed;
  return results;
}

std::vector<std::vector<double>> DelayRows(const RateResults& results) {
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < kRatesHz.size(); ++i) {
    const auto N = static_cast<double>(reference::RateMatchingWindow(kRatesHz[i]));
    rows.push_back({kRatesHz[i], N, (N - 1) / 2 * kCycleSeconds * 1e3});
    for (const double delay_s : results.delay_s[i]) rows.back().push_back(1e3 * delay_s);
  }
  return rows;
}

void CompareRates(const RateResults& results, const std::vector<std::vector<double>>& rows,
                  Findings& findings) {
  constexpr double kTolerance = 0.1;
  const auto N = static_cast<double>(reference::RateMatchingWindow(kPaperRateHz));
  const double ratio = PaperRiserRatio(results.paper);
  findings.Add("125 Hz, velocity: riser of an update over the increment of a cycle", "", ratio)
      .Paper(N)
      .Demand("8 within 0.1", std::abs(ratio - N) <= kTolerance);
  for (const std::vector<double>& row : rows) {
    for (std::size_t i = 0; i < kInterfaces.size(); ++i) {
      const double delay_ms = row[3 + i];
      Comparison& one = findings.Add(
          fmt::format("{:g} Hz, {}: delay, stage on less off", row[0], kInterfaces[i].name), "ms",
          delay_ms);
      if (row[1] > 1) {  // a window of one does nothing
        one.Demand(fmt::format("{:g} ms within 0.1 ms", row[2]),
                   std::abs(delay_ms - row[2]) <= kTolerance);
      }
      if (IsPapers(row[0], kInterfaces[i])) one.Paper(3.5);
    }
  }
  findings.Add("Runs that did not end well", "", results.failed_runs)
      .Demand("none", results.failed_runs == 0);
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
  const RateResults results = MeasureRates(config);
  const std::vector<std::vector<double>> rows = DelayRows(results);
  Findings findings;
  CompareRates(results, rows, findings);
  findings.figures = {
      UpdatesFigure(results.paper),
      {.id = "delays",
       .columns = "source [Hz],N,formula [ms],position [ms],velocity [ms],torque [ms]",
       .rows = rows}};
  AddEnvelopes(config, findings);
  return findings;
}

}  // namespace twin::experiment

#include "experiment/rate_matching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/rate_matching_envelope.h"
#include "experiment/recording.h"
#include "experiment/runs.h"
#include "experiment/wave_source.h"
#include "twin/control/registry.h"
#include "twin/reference/moving_average.h"

namespace twin::experiment {
namespace {

using control::CommandInterface;

constexpr double kPaperRateHz = 125;
constexpr double kPaperDelayS = 3.5e-3;
constexpr std::array<double, 6> kRatesHz{1000, 500, 250, 125, 100, 62.5};

struct NamedInterface {
  CommandInterface interface;
  const char* name;
  JointVector CycleSample::*answer;  ///< where the robot's state shows what it took
};
constexpr std::array<NamedInterface, 3> kInterfaces{
    {{CommandInterface::kJointPosition, "position", &CycleSample::q_d},
     {CommandInterface::kJointVelocity, "velocity", &CycleSample::dq_d},
     {CommandInterface::kTorque, "torque", &CycleSample::tau_J_d}}};

/// A source of one rate on one interface, the stage off and on.
struct Pair {
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

scenario::Scenario MakeScenario(const Setting& setting, CommandInterface interface, double rate_hz,
                                bool stage) {
  scenario::Scenario scenario = LoadScenario(setting, "asynchronous");
  scenario.seed = SeedOfRun(setting, 0);
  scenario.motion.interface = interface;
  scenario.tick.generator = interface == CommandInterface::kJointPosition ? loop::Generator::kJoint
                                                                          : loop::Generator::kNone;
  scenario.tick.rate_matching = stage;
  scenario.tick.limiter = false;
  scenario.tick.finish_tolerance = 1e-2;
  scenario.controller.rate_hz = rate_hz;
  // No state comes late: a cycle that goes unserved would shape the commands, too.
  scenario.link.state.delay = {rt::ConstantDelay{std::chrono::microseconds(100)}};
  const JointVector q = scenario.motion.waypoints.front().q;
  scenario.motion.waypoints = {{.q = q, .at = Duration{}}, {.q = q, .at = WaveSource::kLength}};
  scenario.motion.timing = {};
  return scenario;
}

Pair Measure(const Setting& setting, CommandInterface interface, double rate_hz) {
  control::ControllerRegistry controllers;
  const double acceleration = LargestAcceleration(rate_hz);
  const auto make = [acceleration](const control::ControllerRequest& request) {
    return std::make_unique<WaveSource>(request.interface, request.trajectory.start(),
                                        acceleration);
  };
  const run::Catalogue catalogue{setting.catalogue.backends, controllers};
  const Setting with_wave = With(setting, catalogue);
  constexpr std::size_t kRoom = 8192;  // cycles: more than the swing has
  Pair pair{.off = Recording(kRoom), .on = Recording(kRoom)};
  const auto run = [&](bool stage, Recording& recording) {
    const scenario::Scenario scenario = MakeScenario(setting, interface, rate_hz, stage);
    if (controllers.Names().empty()) controllers.Add(scenario.controller.type, make);
    return RunScenario(with_wave, scenario, &recording).report.succeeded();
  };
  const bool off = run(false, pair.off);
  const bool on = run(true, pair.on);
  pair.ended_well = off && on;
  return pair;
}

/// Group delay of `on` behind `off`: each one's lag behind the wave by least squares, and their
/// difference.
double DelayOf(const Pair& pair, const NamedInterface& interface, double acceleration) {
  const auto delay = [&](const Recording& recording) {
    const std::vector<double> signal =
        Signal(recording.cycles(), interface.answer, 0, 0, recording.cycles().size());
    return WaveDelay(interface.interface, acceleration, signal);
  };
  return delay(pair.on) - delay(pair.off);
}

/// Command of joint 1 of each tick, by the state it answers.
std::vector<double> Commands(const Recording& recording) {
  std::vector<double> commands;
  for (const TickSample& tick : recording.ticks()) {
    while (!commands.empty() &&
           recording.ticks().front().message_id + commands.size() < tick.message_id) {
      commands.push_back(std::nan(""));  // this state was not answered
    }
    commands.push_back(tick.dq_c[0]);
  }
  return commands;
}

/// Riser of each update with the stage off, over the increment a cycle that the stage makes of it;
/// of updates that stood N cycles and are large enough to be told from none. @returns their median.
double RiserRatio(const Pair& pair, std::size_t N, double least) {
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
  if (ratios.empty()) return 0;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::ranges::nth_element(ratios, middle);
  return *middle;
}

double PaperRiserRatio(const Pair& pair) {
  const std::size_t N = reference::RateMatchingWindow(kPaperRateHz);
  const double least =
      0.2 * static_cast<double>(N) * LargestAcceleration(kPaperRateHz) * kCycleSeconds;
  return RiserRatio(pair, N, least);
}

/// The paper's figure: commanded velocity of joint 1, and what each cycle adds to it.
Figure UpdatesFigure(const Pair& pair) {
  Figure figure{
      .id = "updates",
      .columns = "t [s],off [rad/s],on [rad/s],increment off [rad/s],increment on [rad/s]"};
  const std::vector<double> off = Commands(pair.off);
  const std::vector<double> on = Commands(pair.on);
  for (std::size_t k = 1; k < std::min(off.size(), on.size()); ++k) {
    figure.rows.push_back({static_cast<double>(k) * kCycleSeconds, off[k], on[k],
                           off[k] - off[k - 1], on[k] - on[k - 1]});
  }
  return figure;
}

/// All rates on all interfaces.
struct Measured {
  std::array<std::array<double, kInterfaces.size()>, kRatesHz.size()> delay_s{};
  int runs_that_failed = 0;
  Pair paper;  ///< the paper's: 125 Hz, velocity
};

Measured MeasureAll(const Setting& setting) {
  constexpr std::size_t kColumns = kInterfaces.size();
  Measured measured;
  std::array<bool, kRatesHz.size() * kColumns> ended_well{};
  InParallel(setting, static_cast<int>(ended_well.size()), [&](int i) {
    const std::size_t rate = static_cast<std::size_t>(i) / kColumns;
    const std::size_t column = static_cast<std::size_t>(i) % kColumns;
    const NamedInterface& interface = kInterfaces[column];
    Pair pair = Measure(setting, interface.interface, kRatesHz[rate]);
    measured.delay_s[rate][column] = DelayOf(pair, interface, LargestAcceleration(kRatesHz[rate]));
    ended_well[static_cast<std::size_t>(i)] = pair.ended_well;
    if (kRatesHz[rate] == kPaperRateHz && interface.interface == CommandInterface::kJointVelocity) {
      measured.paper = std::move(pair);
    }
  });
  measured.runs_that_failed = static_cast<int>(std::ranges::count(ended_well, false));
  return measured;
}

std::vector<std::vector<double>> DelayRows(const Measured& measured) {
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < kRatesHz.size(); ++i) {
    const auto N = static_cast<double>(reference::RateMatchingWindow(kRatesHz[i]));
    rows.push_back({kRatesHz[i], N, (N - 1) / 2 * kCycleSeconds * 1e3});
    for (const double delay_s : measured.delay_s[i]) rows.back().push_back(1e3 * delay_s);
  }
  return rows;
}

void Compare(const Measured& measured, const std::vector<std::vector<double>>& rows,
             std::vector<Comparison>& out) {
  constexpr double kTolerance = 0.1;
  const std::size_t N = reference::RateMatchingWindow(kPaperRateHz);
  const double ratio = PaperRiserRatio(measured.paper);
  out.push_back({"125 Hz, velocity: riser of an update over the increment of a cycle",
                 "",
                 static_cast<double>(N),
                 ratio,
                 {},
                 {},
                 "8 within 0.1",
                 Judge(std::abs(ratio - static_cast<double>(N)) <= kTolerance)});
  for (const std::vector<double>& row : rows) {
    for (std::size_t i = 0; i < kInterfaces.size(); ++i) {
      const bool is_paper =
          row[0] == kPaperRateHz && kInterfaces[i].interface == CommandInterface::kJointVelocity;
      Comparison comparison{.quantity = fmt::format("{:g} Hz, {}: delay, stage on less off", row[0],
                                                    kInterfaces[i].name),
                            .unit = "ms",
                            .paper = {},
                            .ours = row[3 + i],
                            .low = {},
                            .high = {},
                            .demand = {}};
      if (row[1] > 1) {  // a window of one does nothing
        comparison.demand = fmt::format("{:g} ms within 0.1 ms", row[2]);
        comparison.verdict = Judge(std::abs(row[3 + i] - row[2]) <= kTolerance);
      }
      if (is_paper) comparison.paper = 1e3 * kPaperDelayS;
      out.push_back(std::move(comparison));
    }
  }
  out.push_back({"Runs that did not end well",
                 "",
                 {},
                 static_cast<double>(measured.runs_that_failed),
                 {},
                 {},
                 "none",
                 Judge(measured.runs_that_failed == 0)});
}

}  // namespace

Findings RunRateMatchingOnWallClock(const Setting& setting) {
  const Pair pair = Measure(setting, CommandInterface::kJointVelocity, kPaperRateHz);
  Findings findings;
  findings.comparisons.push_back(
      {.quantity = "125 Hz, velocity: riser of an update over the increment of a cycle",
       .paper = static_cast<double>(reference::RateMatchingWindow(kPaperRateHz)),
       .ours = PaperRiserRatio(pair)});
  findings.comparisons.push_back(
      {.quantity = "Both runs ended well", .unit = "%", .ours = pair.ended_well ? 100.0 : 0.0});
  findings.figures = {UpdatesFigure(pair)};
  return findings;
}

Findings RunRateMatching(const Setting& setting) {
  const Measured measured = MeasureAll(setting);
  const std::vector<std::vector<double>> rows = DelayRows(measured);
  Findings findings;
  Compare(measured, rows, findings.comparisons);
  findings.figures = {
      UpdatesFigure(measured.paper),
      {.id = "delays",
       .columns = "source [Hz],N,formula [ms],position [ms],velocity [ms],torque [ms]",
       .rows = rows}};
  AddEnvelopes(setting, findings);
  return findings;
}

}  // namespace twin::experiment

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/busy_controller.h"
#include "experiment/loop_runs.h"
#include "experiment/table_one.h"
#include "experiment/timings.h"
#include "experiment/timings_figures.h"
#include "twin/experiment/calibration.h"

namespace twin::experiment {
namespace {

// Places in CalibratedLoops().
constexpr std::size_t kBare = 0;
constexpr std::size_t kSynchronous = 1;
constexpr std::size_t kAsynchronous = 2;

/// What the controllers of a ROS 2 stack cost. An input: Table 1's median d_EXT of RS less that of
/// LF, in whose place nothing else stands; so RS's d_EXT is no finding here.
constexpr Duration kLoad = std::chrono::microseconds(65 - 12);

/// What must hold on any machine.
constexpr double kMostLatency = 1.2;       ///< median d_EXT, RA to LF
constexpr double kLeastUnserved = 5;       ///< unserved cycles, RS to RA
constexpr double kMostBareUnserved = 1.0;  ///< %, of LF: above it the machine itself is at fault

using OfSample = std::function<double(const LoopSample&)>;

/// The median of the runs, and the lowest and the highest of them.
Comparison MedianOf(std::string quantity, std::string unit, const std::vector<LoopSample>& runs,
                    const OfSample& of) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const LoopSample& run : runs) values.push_back(of(run));
  std::ranges::sort(values);
  return {.quantity = std::move(quantity),
          .unit = std::move(unit),
          .ours = Percentile(values, 0.5),
          .low = values.front(),
          .high = values.back()};
}

double Median(const std::vector<LoopSample>& runs, const OfSample& of) {
  return MedianOf({}, {}, runs, of).ours;
}

void AddTable(const LoopRuns& runs, std::vector<Comparison>& out) {
  for (std::size_t loop = 0; loop < runs.size(); ++loop) {
    for (const TableRow& quantity : kTableOne) {
      out.push_back(MedianOf(fmt::format("{}, {}", CalibratedLoops()[loop].name, quantity.name),
                             quantity.unit, runs[loop], quantity.of));
      out.back().paper = quantity.paper[loop];
    }
  }
}

void AddDemands(const LoopRuns& runs, std::vector<Comparison>& out) {
  const OfSample latency = kTableOne[kMedianLatency].of;
  const double ratio = Median(runs[kAsynchronous], latency) / Median(runs[kBare], latency);
  out.push_back({.quantity = "median d_EXT, RA to LF",
                 .paper = 13.0 / 12.0,
                 .ours = ratio,
                 .demand = fmt::format("at most {}", kMostLatency),
                 .verdict = Judge(ratio <= kMostLatency)});
  const OfSample unserved = kTableOne[kUnserved].of;
  const double bare = Median(runs[kBare], unserved);
  const double asynchronous = Median(runs[kAsynchronous], unserved);
  // None at all is better than any share: the ratio is then that to one cycle of the run.
  const double one = 100.0 / static_cast<double>(runs[kAsynchronous].front().cycles);
  const double times = Median(runs[kSynchronous], unserved) / std::max(asynchronous, one);
  Comparison unserved_ratio{.quantity = "unserved cycles, RS to RA",
                            .paper = 14.4,
                            .ours = times,
                            .demand = fmt::format("at least {}", kLeastUnserved),
                            .verdict = Judge(times >= kLeastUnserved)};
  if (bare >= kMostBareUnserved) {
    unserved_ratio.verdict = Verdict::kReported;
    unserved_ratio.demand = fmt::format(
        "not judged: LF itself leaves {:.2g} % unserved on this machine, {} % are the "
        "most with which it would be",
        bare, kMostBareUnserved);
  }
  out.push_back(std::move(unserved_ratio));
}

/// What tells a fault of the loop from one of the machine.
void AddMachine(const LoopRuns& runs, std::vector<Comparison>& out) {
  for (std::size_t loop = 0; loop < runs.size(); ++loop) {
    const auto name = CalibratedLoops()[loop].name;
    const auto add = [&](const char* what, const char* unit, const OfSample& of) {
      out.push_back(MedianOf(fmt::format("{}, {}", name, what), unit, runs[loop], of));
    };
    add("most unserved in a row (20 end the motion)", "cycles",
        [](const LoopSample& s) { return static_cast<double>(s.longest_loss); });
    add("motions that reached their goal", "%",
        [](const LoopSample& s) { return s.succeeded ? 100.0 : 0.0; });
    add("cycles the robot's own thread began late, p99", "us",
        [](const LoopSample& s) { return s.robot_late_p99_us; });
    add("periods this machine did not give the robot's thread", "",
        [](const LoopSample& s) { return static_cast<double>(s.robot_overruns); });
  }
}

}  // namespace

Findings RunTimingsOnWallClock(const Setting& setting) {
  const control::ControllerRegistry loaded = Loaded(setting.catalogue.controllers, kLoad);
  const LoopRuns runs = RunLoops(setting, {setting.catalogue.backends, loaded}, 1);
  Findings findings{
      .values = {{"runs", fmt::format("{}", setting.seeds)},
                 {"load_us", fmt::format("{}", kLoad / std::chrono::microseconds(1))}}};
  AddTable(runs, findings.comparisons);
  const double load_us = 1e6 * ToSeconds(kLoad);
  findings.comparisons.push_back(
      {.quantity = "RS and RA, what their controllers keep the processor busy for",
       .unit = "us",
       .paper = load_us,
       .ours = load_us,
       .verdict = Verdict::kCalibrated});
  AddDemands(runs, findings.comparisons);
  AddMachine(runs, findings.comparisons);
  findings.figures = {LatencyFigure(runs), IntervalFigure(runs)};
  return findings;
}

}  // namespace twin::experiment

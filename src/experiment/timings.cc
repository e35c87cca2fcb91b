#include "experiment/timings.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/loop_runs.h"
#include "experiment/table_one.h"
#include "experiment/timings_figures.h"
#include "twin/experiment/calibration.h"

namespace twin::experiment {
namespace {

constexpr double kShareOfTable = 0.6;  ///< of the whole work

/// How near a row of Table 1 must come.
struct Demand {
  double most;  ///< how often the paper's figure ours may be, or it ours
  const char* text;
};
constexpr Demand kNear{1.2, "within 20 % of the paper's"};
constexpr Demand kRoughly{2, "within a factor of 2 of the paper's"};

std::vector<double> Values(const std::vector<LoopSample>& runs,
                           const std::function<double(const LoopSample&)>& of) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const LoopSample& run : runs) values.push_back(of(run));
  return values;
}

/// Within 20 % is both ways: from 0.8 to 1.2 times. Within a factor of 2: from half to double.
bool IsNear(double ours, double paper, double most) {
  const double least = most < 2 ? 2 - most : 1 / most;
  return ours >= least * paper && ours <= most * paper;
}

Comparison Compare(std::size_t row, std::size_t loop, const std::vector<LoopSample>& runs) {
  const TableRow& quantity = kTableOne[row];
  const Demand& demand = row == kLargestLatency ? kRoughly : kNear;
  const Spread spread = SpreadOf(Values(runs, quantity.of));
  const double paper = quantity.paper[loop];
  return {.quantity = fmt::format("{}, {}", CalibratedLoops()[loop].name, quantity.name),
          .unit = quantity.unit,
          .paper = paper,
          .ours = spread.mean,
          .low = spread.low,
          .high = spread.high,
          .demand = demand.text,
          .verdict = Judge(IsNear(spread.mean, paper, demand.most))};
}

/// How many cycles the synchronous loop leaves unserved for each of the asynchronous one's.
Comparison CompareRatio(const LoopRuns& runs) {
  const auto unserved = [](const LoopSample& s) { return s.unserved_percent; };
  const Spread synchronous = SpreadOf(Values(runs[1], unserved));
  const Spread asynchronous = SpreadOf(Values(runs[2], unserved));
  const double ratio = synchronous.mean / asynchronous.mean;
  return {.quantity = "unserved cycles, RS to RA",
          .paper = 14.4,
          .ours = ratio,
          .low = synchronous.low / asynchronous.high,
          .high = synchronous.high / asynchronous.low,
          .demand = "10 to 20",
          .verdict = Judge(ratio >= 10 && ratio <= 20)};
}

Comparison Report(std::string quantity, std::string unit, const std::vector<double>& values) {
  const Spread spread = SpreadOf(values);
  return {.quantity = std::move(quantity),
          .unit = std::move(unit),
          .ours = spread.mean,
          .low = spread.low,
          .high = spread.high};
}

/// What Table 1 does not tell and matters beside it.
void AddReported(const LoopRuns& runs, std::vector<Comparison>& comparisons) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto name = CalibratedLoops()[i].name;
    comparisons.push_back(Report(
        fmt::format("{}, most unserved in a row (20 end the motion)", name), "cycles",
        Values(runs[i], [](const LoopSample& s) { return static_cast<double>(s.longest_loss); })));
    comparisons.push_back(
        Report(fmt::format("{}, motions that reached their goal", name), "%",
               Values(runs[i], [](const LoopSample& s) { return s.succeeded ? 100.0 : 0.0; })));
  }
}

/// Share of the intervals within a quarter of a cycle of `cycles`, in %.
double ShareNear(const LoopSample& sample, double cycles) {
  std::size_t near = 0;
  for (const double interval : sample.interval_us) {
    if (std::abs(interval - 1e3 * cycles) < 250) ++near;
  }
  return 100 * static_cast<double>(near) / static_cast<double>(sample.interval_us.size());
}

void AddPeaks(const LoopRuns& runs, std::vector<Comparison>& comparisons) {
  for (const int cycles : {1, 2, 3}) {
    comparisons.push_back(Report(
        fmt::format("RS, peak {}: intervals within 0.25 ms of {} ms", "ABC"[cycles - 1], cycles),
        "%", Values(runs[1], [cycles](const LoopSample& s) { return ShareNear(s, cycles); })));
  }
  for (const std::size_t loop : {std::size_t{0}, std::size_t{2}}) {
    comparisons.push_back(
        Report(fmt::format("{}, intervals within 0.25 ms of 1 ms", CalibratedLoops()[loop].name),
               "%", Values(runs[loop], [](const LoopSample& s) { return ShareNear(s, 1); })));
  }
}

std::string Text(const Setting& setting) {
  return fmt::format(
      "Each loop drives the same motion {} times on the virtual clock, with seeds and start phases "
      "drawn from seed {}; the bare loop has no phase. d_EXT is the time from the end of a state's "
      "read to the end of its command's write; a cycle is unserved when the robot had no command "
      "in time and held the last acceleration. The figures are means over the runs, the spread "
      "the lowest and the highest run. {} No cycle is made to fail, and every other experiment "
      "takes the delays as they are (calibration {}).",
      setting.seeds, setting.seed,
      setting.is_calibrated
          ? "The delays of the three loops were calibrated on this table, and on nothing else."
          : "The delays are not the paper's but those that were given with --calibration, so the "
            "paper's figures stand beside them for comparison, and nothing is demanded.",
      ReadCalibration(setting.scenarios).hash);
}

}  // namespace

Findings RunTimings(const Setting& setting) {
  Findings findings{.id = "timings",
                    .title = "Loop timings (Table 1)",
                    .source = "Section 2, Table 1 and the figure of read-to-read intervals",
                    .text = Text(setting)};
  const LoopRuns runs = RunLoops(setting, setting.catalogue, kShareOfTable);
  for (std::size_t loop = 0; loop < runs.size(); ++loop) {
    for (std::size_t row = 0; row < kTableOne.size(); ++row) {
      findings.comparisons.push_back(Compare(row, loop, runs[loop]));
    }
  }
  findings.comparisons.push_back(CompareRatio(runs));
  if (!setting.is_calibrated) {
    for (Comparison& comparison : findings.comparisons) {
      comparison.demand.clear();
      comparison.verdict = Verdict::kReported;
    }
  }
  AddReported(runs, findings.comparisons);
  AddPeaks(runs, findings.comparisons);
  findings.figures = {LatencyFigure(runs), IntervalFigure(runs),
                      SensitivityFigure(setting, kShareOfTable)};
  return findings;
}

}  // namespace twin::experiment

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "experiment/jitter.h"
#include "experiment/loop_sample.h"
#include "experiment/runs.h"
#include "twin/core/time.h"

namespace twin::experiment {
namespace {

constexpr int kMostRuns = 3;  // of each way: 18 s a run

/// Source times of the deposits that were taken.
class DepositTimes final : public rt::RecordSink {
 public:
  DepositTimes() { times_.reserve(kRoom); }
  void Put(const rt::CycleRecord& /*record*/) noexcept override {}
  void Put(const rt::TickRecord& record) noexcept override {
    if (record.action != rt::TickAction::kWritten) return;
    if (times_.empty() || times_.back() != record.deposit_time) {
      times_.push_back(record.deposit_time);
    }
  }

  /// How far the way from one to the next is off a cycle, us, rising. Deposits that were never
  /// taken are passed over.
  [[nodiscard]] std::vector<double> OffCycle() const {
    std::vector<double> off;
    for (std::size_t i = 1; i < times_.size(); ++i) {
      const double way_us = 1e6 * ToSeconds(times_[i] - times_[i - 1]);
      const double cycles = std::max(1.0, std::round(way_us / 1e3));
      off.push_back(std::abs(way_us - 1e3 * cycles));
    }
    std::ranges::sort(off);
    return off;
  }

 private:
  static constexpr std::size_t kRoom = 32768;
  std::vector<Time> times_;
};

/// Runs that aborted, and the jitter of those that had one.
struct Aborts {
  int runs = 0;
  int aborted = 0;
  std::vector<double> median_us{};
  std::vector<double> p99_us{};
};

Aborts Count(const Setting& setting, loop::Generator generator) {
  Aborts aborts{.runs = std::min(setting.seeds, kMostRuns)};
  InParallel(setting, aborts.runs, [&](int run) {
    scenario::Scenario scenario = LoadScenario(setting, "asynchronous");
    scenario.seed = SeedOfRun(setting, run);
    scenario.tick.limiter = false;
    scenario.tick.generator = generator;
    DepositTimes times;
    if (!RunScenario(setting, scenario, &times).report.succeeded()) ++aborts.aborted;
    const std::vector<double> off = times.OffCycle();
    if (off.empty()) return;
    aborts.median_us.push_back(Percentile(off, 0.5));
    aborts.p99_us.push_back(Percentile(off, 0.99));
  });
  return aborts;
}

Comparison Report(std::string quantity, const std::vector<double>& values) {
  const Spread spread = SpreadOf(values);
  return {.quantity = std::move(quantity),
          .unit = "us",
          .ours = spread.mean,
          .low = spread.low,
          .high = spread.high};
}

}  // namespace

Findings RunJitterOnWallClock(const Setting& setting) {
  const Aborts raw = Count(setting, loop::Generator::kNone);
  const Aborts generated = Count(setting, loop::Generator::kJoint);
  Findings findings;
  const auto share = [&](const char* name, const Aborts& aborts, double paper) {
    findings.comparisons.push_back(
        {.quantity = fmt::format("{}: aborts in {} runs", name, aborts.runs),
         .unit = "%",
         .paper = paper,
         .ours = 100.0 * aborts.aborted / aborts.runs});
  };
  share("raw stream", raw, 100);
  share("reference generator", generated, 0);
  findings.comparisons.push_back(
      Report("from one sample to the next, off a cycle: median", generated.median_us));
  findings.comparisons.push_back(Report("the same, p99", generated.p99_us));
  return findings;
}

}  // namespace twin::experiment

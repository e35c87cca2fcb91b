#include "experiment/loop_sample.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <variant>

#include "experiment/runs.h"
#include "twin/core/check.h"

namespace twin::experiment {
namespace {

/// Reads the times off the ticks.
class TickTimes final : public rt::RecordSink {
 public:
  TickTimes() {
    // On the wall clock nothing is allocated while a run goes on: half a minute fits.
    sample.interval_us.reserve(kTicks);
    sample.d_EXT_us.reserve(kTicks);
  }
  void Put(const rt::CycleRecord& /*record*/) noexcept override {}
  void Put(const rt::TickRecord& record) noexcept override {
    if (last_read_) sample.interval_us.push_back(1e6 * ToSeconds(record.read - *last_read_));
    last_read_ = record.read;
    if (record.action == rt::TickAction::kWritten || record.action == rt::TickAction::kFinished) {
      sample.d_EXT_us.push_back(1e6 * ToSeconds(record.written - record.read));
    }
  }

  LoopSample sample;

 private:
  static constexpr std::size_t kTicks = 32768;

  std::optional<Time> last_read_;
};

Duration Scaled(Duration duration, double factor) {
  return Duration(std::llround(factor * static_cast<double>(duration.count())));
}

}  // namespace

LoopSample SampleLoop(const Setting& setting, const scenario::Scenario& scenario) {
  TickTimes times;
  const run::RunResult result = RunScenario(setting, scenario, &times);
  LoopSample& sample = times.sample;
  std::ranges::sort(sample.d_EXT_us);
  const auto& counts = result.counts;
  sample.cycles = counts.cycles();
  sample.unserved_percent = counts.unserved_percent();
  sample.longest_loss = counts.longest_loss;
  sample.succeeded = result.report.succeeded();
  sample.failure = result.report.failure;
  const backend::RobotTimings& robot = result.report.robot_timings;
  sample.robot_late_p99_us = 1e6 * ToSeconds(robot.lateness.Percentile(0.99));
  sample.robot_overruns = robot.overruns;
  return std::move(sample);
}

double Percentile(std::span<const double> sorted, double share) {
  TWIN_CHECK(!sorted.empty());
  const double rank = std::ceil(share * static_cast<double>(sorted.size()));
  const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  return sorted[std::min(index, sorted.size() - 1)];
}

Spread SpreadOf(std::span<const double> values) {
  if (values.empty()) return {};
  const auto [low, high] = std::ranges::minmax(values);
  return {std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()),
          low, high};
}

std::vector<double> Histogram(std::span<const double> values, std::span<const double> edges) {
  std::vector<double> shares(edges.size() - 1);
  for (const double value : values) {
    const auto above = std::ranges::upper_bound(edges, value);
    if (above == edges.begin() || above == edges.end()) continue;
    ++shares[static_cast<std::size_t>(above - edges.begin()) - 1];
  }
  if (!values.empty()) {
    for (double& share : shares) share /= static_cast<double>(values.size());
  }
  return shares;
}

std::vector<double> Exceedance(std::vector<double> values, std::span<const double> edges) {
  std::ranges::sort(values);
  std::vector<double> shares;
  for (const double edge : edges) {
    const auto above = values.end() - std::ranges::upper_bound(values, edge);
    shares.push_back(
        values.empty() ? 0 : static_cast<double>(above) / static_cast<double>(values.size()));
  }
  return shares;
}

std::vector<double> LogEdges(double from, double to, int per_decade) {
  std::vector<double> edges;
  for (int i = 0; edges.empty() || edges.back() < to; ++i) {
    edges.push_back(from * std::pow(10, static_cast<double>(i) / per_decade));
  }
  return edges;
}

scenario::Delay Scaled(const scenario::Delay& delay, double factor) {
  scenario::Delay scaled = delay;
  if (auto* constant = std::get_if<rt::ConstantDelay>(&scaled.law)) {
    constant->value = Scaled(constant->value, factor);
  } else if (auto* log_normal = std::get_if<rt::LogNormalDelay>(&scaled.law)) {
    log_normal->median = Scaled(log_normal->median, factor);
    log_normal->offset = Scaled(log_normal->offset, factor);
  } else if (auto* normal = std::get_if<rt::NormalDelay>(&scaled.law)) {
    normal->mean = Scaled(normal->mean, factor);
    normal->sigma = Scaled(normal->sigma, factor);
  } else if (auto* gamma = std::get_if<rt::GammaDelay>(&scaled.law)) {
    gamma->scale = Scaled(gamma->scale, factor);
    gamma->offset = Scaled(gamma->offset, factor);
  } else {
    for (Duration& edge : std::get<rt::EmpiricalDelay>(scaled.law).edges) {
      edge = Scaled(edge, factor);
    }
  }
  return scaled;
}

}  // namespace twin::experiment

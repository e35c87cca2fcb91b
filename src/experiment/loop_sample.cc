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
  std::optional<Time> last_read_;
};

Duration Scaled(Duration duration, double factor) {
  return Duration(std::llround(factor * static_cast<double>(duration.count())));
}

}  // namespace

LoopSample SampleLoop(const Setting& setting, const scenario::Scenario& scenario) {
  TickTimes times;
  const scenario::RunResult result = RunScenario(setting, scenario, &times);
  LoopSample& sample = times.sample;
  std::ranges::sort(sample.d_EXT_us);
  const auto& counts = result.counts;
  const auto cycles = static_cast<double>(counts.served + counts.held);
  sample.unserved_percent = cycles > 0 ? 100 * static_cast<double>(counts.held) / cycles : 0;
  sample.longest_loss = counts.longest_loss;
  sample.succeeded = result.report.succeeded();
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

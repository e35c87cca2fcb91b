#include "twin/report/deviation.h"

#include <array>
#include <cmath>
#include <cstdint>

#include "report/target_match.h"
#include "twin/core/time.h"
#include "twin/record/log_reader.h"

namespace twin::report {
namespace {

/// Takes the records of a log as std::visit gives them.
class Collector {
 public:
  void operator()(const rt::CycleRecord& cycle) {
    if (cycle.state.controller_mode != ControllerMode::kOther) Take(match_.Add(cycle));
  }
  void operator()(const rt::TickRecord& tick) { Take(match_.Add(tick)); }
  template <class Other>
  void operator()(const Other& /*record*/) {}

  [[nodiscard]] std::optional<Deviation> Result() const {
    if (count_ == 0) return std::nullopt;
    Deviation deviation = largest_;
    deviation.rms = std::sqrt(squares_[largest_.joint] / static_cast<double>(count_));
    return deviation;
  }

 private:
  void Take(const std::optional<TargetMatch::Pair>& pair) {
    if (!pair) return;
    ++count_;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double error = std::abs(pair->q_ext[i] - pair->q[i]);
      squares_[i] += error * error;
      if (error <= largest_.largest) continue;
      largest_ = {
          .largest = error, .joint = i, .at = ToSeconds(pair->at.time_since_epoch()), .rms = 0};
    }
  }

  TargetMatch match_;
  Deviation largest_;
  std::array<double, kJoints> squares_{};
  std::uint64_t count_ = 0;
};

}  // namespace

std::optional<Deviation> MeasureDeviation(const std::filesystem::path& log) {
  record::LogReader reader(log);
  Collector collector;
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  return collector.Result();
}

}  // namespace twin::report

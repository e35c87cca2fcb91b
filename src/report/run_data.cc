#include "report/run_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "report/run_end.h"
#include "report/target_match.h"
#include "report/tracking_error.h"
#include "twin/core/error.h"
#include "twin/core/robot_errors.h"
#include "twin/core/time.h"

namespace twin::report {
namespace {

/// Largest number of spans side by side in a panel.
constexpr std::size_t kMaxSpans = 300;

double Seconds(Time time) {
  return ToSeconds(time.time_since_epoch());
}

FateCounts CountsOf(const record::CycleRecord& cycle) {
  return {.begin = Seconds(cycle.at),
          .served = cycle.fate == record::CommandFate::kServed ? 1U : 0U,
          .held = cycle.fate == record::CommandFate::kHeld ? 1U : 0U,
          .none = cycle.fate == record::CommandFate::kNone ? 1U : 0U,
          .dropped = cycle.dropped};
}

/// Raises `peaks` to the magnitudes of `values`; ignores values that are not finite.
void UpdatePeaks(JointVector& peaks, const JointVector& values) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::isfinite(values[i])) peaks[i] = std::max(peaks[i], std::abs(values[i]));
  }
}

/// Name of a state's error: that with details in the cycle, else the first. @pre it has an error.
std::string ErrorName(const record::CycleRecord& cycle) {
  const RobotErrors& errors = cycle.state.errors;
  std::size_t first = 0;
  while (!errors[first]) ++first;
  const RobotError error = cycle.violated ? cycle.violation.error : static_cast<RobotError>(first);
  const std::size_t others = errors.count() - 1;
  return fmt::format("{}{}", twin::Name(error),
                     others > 0 ? fmt::format(" and {} more", others) : "");
}

/// Visitor of a log's records.
class DataCollector {
 public:
  explicit DataCollector(RunData& run) : run_(run) {}

  void operator()(const record::CycleRecord& cycle) {
    const double time = Seconds(cycle.at);
    if (run_.total.cycles() == 0) run_.begin = time;
    run_.end = time;
    run_.total.Add(CountsOf(cycle));
    if (!run_.abort && cycle.state.errors.any()) run_.abort = Abort{time, ErrorName(cycle)};
    const bool moves = cycle.state.robot_mode == RobotMode::kMove;
    if (moves && !moved_ && run_.motions.size() < RunData::kMostMotions) {
      run_.motions.push_back(time);
    }
    moved_ = moves;
    run_.longest_loss = std::max(run_.longest_loss, cycle.lost_in_row);
    run_.fates.Add(cycle);
    UpdatePeaks(run_.peak_dq, cycle.state.dq);
    UpdatePeaks(run_.peak_dq_d, cycle.state.dq_d);
    UpdatePeaks(run_.peak_tau, cycle.state.tau_J);
    UpdatePeaks(run_.peak_tau, cycle.state.tau_J_d);
    UpdatePeaks(run_.peak_dddq_d, cycle.dddq_d);
    AddError(tracking_.Add(cycle));
    AddDeviation(plan_.Add(cycle));
    run_.by_torque = tracking_.by_torque();
    run_.q.Add(time, cycle.state.q);
    run_.q_d.Add(time, cycle.state.q_d);
    run_.dq.Add(time, cycle.state.dq);
    run_.dq_d.Add(time, cycle.state.dq_d);
    run_.dddq_d.Add(time, cycle.dddq_d);
    run_.tau_J.Add(time, cycle.state.tau_J);
    run_.tau_J_d.Add(time, cycle.state.tau_J_d);
    if (moves) {
      run_.success_rate.Add(time, std::array{cycle.state.control_command_success_rate});
    }
  }

  void operator()(const record::TickRecord& tick) {
    AddError(tracking_.Add(tick));
    AddDeviation(plan_.Add(tick));
    if (std::ranges::any_of(tick.q_ext, [](double x) { return x != 0; })) {
      run_.q_ext.Add(Seconds(tick.read), tick.q_ext);
      run_.dq_ext.Add(Seconds(tick.read), tick.dq_ext);
    }
    AddFiltered(tick);
    if (!WroteCommand(tick)) return;
    run_.d_EXT.Add(Seconds(tick.read), std::array{ToSeconds(tick.written - tick.read) * 1e6});
  }

  template <class Other>
  void operator()(const Other& /*record*/) {}

 private:
  void AddFiltered(const record::TickRecord& tick) {
    run_.filter.Add(tick);
    if (!tick.margin) return;
    run_.margin.Add(Seconds(tick.read), std::array{*tick.margin});
    if (tick.kept_back == 0) return;
    JointVector joints{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      const bool active = ((tick.kept_back >> i) & 1U) != 0;
      joints[i] = active ? static_cast<double>(i + 1) : std::numeric_limits<double>::quiet_NaN();
    }
    run_.kept_back.Add(Seconds(tick.read), joints);
  }

  void AddError(const std::optional<TrackingError::Value>& value) {
    if (!value) return;
    JointVector error{};
    for (std::size_t i = 0; i < kJoints; ++i) error[i] = 1e3 * value->error[i];
    UpdatePeaks(run_.peak_error, error);
    run_.error.Add(Seconds(value->at), error);
  }

  void AddDeviation(const std::optional<TargetMatch::Pair>& pair) {
    if (!pair) return;
    JointVector deviation{};
    for (std::size_t i = 0; i < kJoints; ++i) deviation[i] = 1e3 * (pair->q_ext[i] - pair->q[i]);
    UpdatePeaks(run_.peak_deviation, deviation);
    run_.deviation.Add(Seconds(pair->at), deviation);
  }

  RunData& run_;
  bool moved_ = false;  ///< in the previous cycle
  TrackingError tracking_;
  TargetMatch plan_;
};

}  // namespace

void FateCounts::Add(const FateCounts& other) {
  served += other.served;
  held += other.held;
  none += other.none;
  dropped += other.dropped;
}

void FateHistory::Add(const record::CycleRecord& cycle) {
  const FateCounts counts = CountsOf(cycle);
  if (!spans_.empty() && spans_.back().cycles() < cycles_per_span_) {
    spans_.back().Add(counts);
    return;
  }
  if (spans_.size() == kMaxSpans) {
    for (std::size_t i = 0; i < kMaxSpans / 2; ++i) {
      spans_[i] = spans_[2 * i];
      spans_[i].Add(spans_[2 * i + 1]);
    }
    spans_.resize(kMaxSpans / 2);
    cycles_per_span_ *= 2;
  }
  spans_.push_back(counts);
}

RunData ReadRun(const std::filesystem::path& log) {
  record::LogReader reader(log);
  RunData run;
  DataCollector collector(run);
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  if (run.total.cycles() == 0) {
    throw InputError(
        fmt::format("{} holds no cycle of the robot, so there is nothing to plot; "
                    "name the log of a run that began",
                    log.string()));
  }
  run.scenario = reader.run().scenario;
  run.truncated = reader.truncated();
  return run;
}

}  // namespace twin::report

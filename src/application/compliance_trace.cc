#include "application/compliance.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/record/log_reader.h"

namespace twin::application::compliance {
namespace {

Vector3 PositionOf(const Transform& X) noexcept {
  return {X[12], X[13], X[14]};
}

/// Collects the traces from a log's records.
class TraceCollector {
 public:
  TraceCollector(const std::array<std::optional<Span>, kCases>& spans, const JointLimits& limits,
                 Log& log)
      : spans_(spans), limits_(limits), log_(log) {}

  void Add(const record::CycleRecord& cycle) {
    const RobotState& state = cycle.state;
    const bool is_reflex = state.robot_mode == RobotMode::kReflex;
    log_.reflexes += is_reflex && !was_reflex_ ? 1 : 0;
    was_reflex_ = is_reflex;
    if (state.robot_mode == RobotMode::kMove) AddMoving(cycle);
    last_id_ = state.message_id;
    last_tau_J_d_ = state.tau_J_d;
  }

  void Add(const record::TickRecord& tick) {
    if (tick.action != record::TickAction::kFinished) return;
    for (std::size_t i = 0; i < kCases; ++i) {
      if (!IsIn(tick.read, spans_[i]) || finished_[i]) continue;
      finished_[i] = tick.message_id;
    }
  }

  template <class Other>
  void Add(const Other& /*record*/) {}

  /// Removes the samples after a motion's finished command, when the robot stops the arm itself.
  void LeaveOutStops() {
    for (std::size_t i = 0; i < kCases; ++i) {
      if (!finished_[i]) continue;
      std::erase_if(log_.traces[i], [&](const Sample& sample) {
        return first_ids_[i] + sample.cycle > *finished_[i];
      });
    }
  }

 private:
  static bool IsIn(Time at, const std::optional<Span>& span) {
    return span && at >= span->begun && at <= span->ended;
  }

  void AddMoving(const record::CycleRecord& cycle) {
    for (std::size_t i = 0; i < kCases; ++i) {
      if (!IsIn(cycle.at, spans_[i])) continue;
      if (log_.traces[i].empty()) {
        first_ids_[i] = cycle.state.message_id;
        begun_ = cycle.at;
        held_ = cycle.state.O_T_EE;
      }
      log_.traces[i].push_back(SampleOf(cycle, *spans_[i], first_ids_[i]));
      return;
    }
  }

  [[nodiscard]] Sample SampleOf(const record::CycleRecord& cycle, const Span& span,
                                std::uint64_t first_id) const {
    const RobotState& state = cycle.state;
    Sample sample{.cycle = state.message_id - first_id,
                  .at = ToSeconds(cycle.at.time_since_epoch()),
                  .p = PositionOf(state.O_T_EE),
                  .q = state.q};
    const Transform wanted = span.path ? span.path->Sample(cycle.at - begun_).O_T_EE : held_;
    const Vector6 error = model::Displacement(wanted, state.O_T_EE);
    sample.off = {error[0], error[1], error[2]};
    sample.turned = HalfNorm(error, 3);
    for (std::size_t i = 0; i < sample.force.size(); ++i) sample.force[i] = -state.O_F_ext_hat_K[i];
    TakeTorques(state, sample);
    return sample;
  }

  void TakeTorques(const RobotState& state, Sample& sample) const {
    const double since = kCycleSeconds * static_cast<double>(std::max<std::uint64_t>(
                                             state.message_id - last_id_, 1));
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double torque = std::max(std::abs(state.tau_J[j]), std::abs(state.tau_J_d[j]));
      const double rate = std::abs(state.tau_J_d[j] - last_tau_J_d_[j]) / since;
      sample.torque = std::max(sample.torque, torque / limits_.tau_max[j]);
      sample.rate = std::max(sample.rate, rate / limits_.dtau_max[j]);
    }
  }

  const std::array<std::optional<Span>, kCases>& spans_;
  const JointLimits& limits_;
  Log& log_;
  bool was_reflex_ = false;
  std::uint64_t last_id_ = 0;
  JointVector last_tau_J_d_{};
  std::array<std::uint64_t, kCases> first_ids_{};
  std::array<std::optional<std::uint64_t>, kCases> finished_{};  ///< states that were answered so
  Time begun_{};                         ///< first state of the motion under way
  Transform held_ = kIdentityTransform;  ///< where it began
};

}  // namespace

Log ReadLog(const std::filesystem::path& path, const std::array<std::optional<Span>, kCases>& spans,
            const JointLimits& limits) {
  Log log;
  record::LogReader reader(path);
  TraceCollector collector(spans, limits, log);
  record::LogEntry entry;
  while (reader.Next(entry)) {
    std::visit([&collector](const auto& record) { collector.Add(record); }, entry);
  }
  collector.LeaveOutStops();
  return log;
}

}  // namespace twin::application::compliance

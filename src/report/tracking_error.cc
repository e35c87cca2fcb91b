#include "report/tracking_error.h"

#include <algorithm>

namespace twin::report {
namespace {

JointVector Difference(const JointVector& wanted, const JointVector& measured) {
  JointVector error{};
  for (std::size_t i = 0; i < kJoints; ++i) error[i] = wanted[i] - measured[i];
  return error;
}

}  // namespace

std::optional<TrackingError::Value> TrackingError::Add(const rt::CycleRecord& cycle) {
  const RobotState& state = cycle.state;
  if (state.controller_mode != ControllerMode::kOther) {
    by_reference_ = state.controller_mode != ControllerMode::kExternalController;
  }
  if (by_reference_) return Value{cycle.at, Difference(state.q_d, state.q)};
  if (state.controller_mode == ControllerMode::kOther) return std::nullopt;
  by_torque_ = true;
  const std::uint64_t id = state.message_id;
  measured_[id % kKept] = {id, cycle.at, state.q};
  const Entry& target = targets_[id % kKept];
  if (target.message_id != id) return std::nullopt;
  return Value{cycle.at, Difference(target.q, state.q)};
}

std::optional<TrackingError::Value> TrackingError::Add(const rt::TickRecord& tick) {
  if (std::ranges::all_of(tick.q_ext, [](double x) { return x == 0; })) return std::nullopt;
  const std::uint64_t id = tick.message_id + 1;
  targets_[id % kKept] = {id, {}, tick.q_ext};
  const Entry& measured = measured_[id % kKept];
  if (measured.message_id != id) return std::nullopt;
  return Value{measured.at, Difference(tick.q_ext, measured.q)};
}

}  // namespace twin::report

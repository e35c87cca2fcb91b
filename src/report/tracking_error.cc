#include "report/tracking_error.h"

namespace twin::report {
namespace {

JointVector Difference(const JointVector& wanted, const JointVector& measured) {
  JointVector error{};
  for (std::size_t i = 0; i < kJoints; ++i) error[i] = wanted[i] - measured[i];
  return error;
}

std::optional<TrackingError::Value> ErrorOfPair(const std::optional<TargetMatch::Pair>& pair) {
  if (!pair) return std::nullopt;
  return TrackingError::Value{pair->at, Difference(pair->q_ext, pair->q)};
}

}  // namespace

std::optional<TrackingError::Value> TrackingError::Add(const record::CycleRecord& cycle) {
  const RobotState& state = cycle.state;
  if (state.controller_mode != ControllerMode::kOther) {
    by_reference_ = state.controller_mode != ControllerMode::kExternalController;
  }
  if (by_reference_) return Value{cycle.at, Difference(state.q_d, state.q)};
  if (state.controller_mode == ControllerMode::kOther) return std::nullopt;
  by_torque_ = true;
  return ErrorOfPair(match_.Add(cycle));
}

std::optional<TrackingError::Value> TrackingError::Add(const record::TickRecord& tick) {
  return ErrorOfPair(match_.Add(tick));
}

}  // namespace twin::report

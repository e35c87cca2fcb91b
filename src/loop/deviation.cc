#include "twin/loop/deviation.h"

#include <cmath>
#include <limits>

#include "twin/model/transform.h"

namespace twin::loop {
namespace {

/// @returns true if `value` is a new maximum. A value that is not finite counts as infinite.
bool Raise(double& largest, double value) noexcept {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (value <= largest || largest == kInfinite) return false;
  largest = std::isfinite(value) ? value : kInfinite;
  return true;
}

bool HasJoints(const reference::Target& target) noexcept {
  for (const double q : target.joint.q) {
    if (q != 0) return true;
  }
  return false;
}

}  // namespace

void DeviationMeter::Measure(const RobotState& state, Time read) noexcept {
  if (message_id_ == 0 || state.message_id != message_id_ + 1) return;
  if (interface_ == control::CommandInterface::kCartesianPose) {
    MeasurePose(state, read);
  } else if (HasJoints(target_)) {
    MeasureJoints(state, read);
  }
}

void DeviationMeter::MeasureJoints(const RobotState& state, Time read) noexcept {
  if (!largest_.joints) largest_.joints = Deviation::Joints{};
  ++count_;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double error = std::abs(target_.joint.q[i] - state.q[i]);
    squares_[i] += error * error;
    if (!Raise(largest_.joints->largest, error)) continue;
    largest_.joints->joint = i;
    largest_.joints->at = read;
  }
}

void DeviationMeter::MeasurePose(const RobotState& state, Time read) noexcept {
  if (!largest_.pose) largest_.pose = Deviation::Pose{};
  const Transform& target = target_.pose.O_T_EE;
  const double distance = (model::Position(target) - model::Position(state.O_T_EE)).norm();
  const double angle = model::TurnBetween(target, state.O_T_EE).norm();
  if (Raise(largest_.pose->position, distance)) largest_.pose->position_at = read;
  if (Raise(largest_.pose->angle, angle)) largest_.pose->angle_at = read;
}

Deviation DeviationMeter::Result() const noexcept {
  Deviation deviation = largest_;
  if (deviation.joints) {
    deviation.joints->rms =
        std::sqrt(squares_[deviation.joints->joint] / static_cast<double>(count_));
  }
  return deviation;
}

}  // namespace twin::loop

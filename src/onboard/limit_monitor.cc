#include "twin/onboard/limit_monitor.h"

#include <cmath>

#include "twin/core/time.h"

namespace twin::onboard {
namespace {

/// Adds a violation for the first joint whose magnitude is beyond its limit. NaN is beyond any.
void CheckMagnitude(RobotError error, const JointVector& values, const JointVector& limits,
                    std::uint64_t message_id, Violations& found) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(values[i]) <= limits[i] * (1 + kLimitTolerance)) continue;
    found.Add({error, static_cast<std::int8_t>(i), values[i], std::copysign(limits[i], values[i]),
               message_id});
    return;
  }
}

void CheckPosition(RobotError error, const JointVector& q, const JointLimits& limits,
                   std::uint64_t message_id, Violations& found) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const bool below = !(q[i] >= limits.q_min[i] - kLimitTolerance * std::abs(limits.q_min[i]));
    const bool above = !(q[i] <= limits.q_max[i] + kLimitTolerance * std::abs(limits.q_max[i]));
    if (!below && !above) continue;
    found.Add({error, static_cast<std::int8_t>(i), q[i], below ? limits.q_min[i] : limits.q_max[i],
               message_id});
    return;
  }
}

}  // namespace

Violations CheckStep(const JointReference& next, const JointLimits& limits,
                     std::uint64_t message_id, const StepErrors& errors) noexcept {
  Violations found;
  CheckMagnitude(errors.acceleration, next.ddq_d, limits.ddq_max, message_id, found);
  CheckMagnitude(errors.jerk, next.dddq_d, limits.dddq_max, message_id, found);
  if (!found.empty()) return found;
  CheckMagnitude(errors.velocity, next.dq_d, limits.dq_max, message_id, found);
  CheckPosition(errors.position, next.q_d, limits, message_id, found);
  return found;
}

Violations CheckTorqueRate(const JointVector& tau_d, const JointVector& tau_J_d,
                           const JointLimits& limits, std::uint64_t message_id) noexcept {
  JointVector rate{};
  for (std::size_t i = 0; i < kJoints; ++i) rate[i] = (tau_d[i] - tau_J_d[i]) / kCycleSeconds;
  Violations found;
  CheckMagnitude(RobotError::kControllerTorqueDiscontinuity, rate, limits.dtau_max, message_id,
                 found);
  return found;
}

}  // namespace twin::onboard

#include "twin/onboard/limit_monitor.h"

#include <cmath>
#include <cstddef>

#include "onboard/bounds.h"
#include "twin/core/time.h"

namespace twin::onboard {
namespace {

using internal::CheckJointMagnitudes;
using internal::CheckJointRanges;

/// The limit counts at the position before the step, which the client knows from the last state.
void CheckVelocities(RobotError error, const JointReference& next, const JointLimits& limits,
                     std::uint64_t message_id, Violations& found) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double dq = next.dq_d[i];
    const double q = next.q_d[i] - dq * kCycleSeconds;
    const double limit = limits.VelocityLimit(i, q, dq);
    if (internal::IsWithin(std::abs(dq), limit)) continue;
    found.Add({error, static_cast<std::int8_t>(i), dq, std::copysign(limit, dq), message_id});
    return;
  }
}

}  // namespace

Violations CheckStep(const JointReference& next, const JointLimits& limits,
                     std::uint64_t message_id, const StepErrors& errors) noexcept {
  Violations found;
  CheckJointMagnitudes(errors.acceleration, next.ddq_d, limits.ddq_max, message_id, found);
  CheckJointMagnitudes(errors.jerk, next.dddq_d, limits.dddq_max, message_id, found);
  if (!found.empty()) return found;
  CheckVelocities(errors.velocity, next, limits, message_id, found);
  CheckJointRanges(errors.position, next.q_d, limits.q_min, limits.q_max, message_id, found);
  return found;
}

Violations CheckTorqueRate(const JointVector& tau_d, const JointVector& tau_J_d,
                           const JointLimits& limits, std::uint64_t message_id) noexcept {
  JointVector rate{};
  for (std::size_t i = 0; i < kJoints; ++i) rate[i] = (tau_d[i] - tau_J_d[i]) / kCycleSeconds;
  Violations found;
  CheckJointMagnitudes(RobotError::kControllerTorqueDiscontinuity, rate, limits.dtau_max,
                       message_id, found);
  return found;
}

}  // namespace twin::onboard

#include "twin/onboard/limit_monitor.h"

#include "onboard/bounds.h"
#include "twin/core/time.h"

namespace twin::onboard {
namespace {

using internal::CheckJointMagnitudes;
using internal::CheckJointRanges;

}  // namespace

Violations CheckStep(const JointReference& next, const JointLimits& limits,
                     std::uint64_t message_id, const StepErrors& errors) noexcept {
  Violations found;
  CheckJointMagnitudes(errors.acceleration, next.ddq_d, limits.ddq_max, message_id, found);
  CheckJointMagnitudes(errors.jerk, next.dddq_d, limits.dddq_max, message_id, found);
  if (!found.empty()) return found;
  CheckJointMagnitudes(errors.velocity, next.dq_d, limits.dq_max, message_id, found);
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

#include "twin/onboard/goal_approach.h"

#include <algorithm>
#include <cmath>

#include "twin/reference/rate_limiter.h"

namespace twin::onboard {
namespace {

constexpr double kGain = 10;            ///< 1/s, close to the goal
constexpr double kShareOfLimit = 0.95;  ///< of a velocity limit that depends on the position

}  // namespace

JointReference ApproachStep(const JointReference& reference, const JointVector& goal,
                            const JointVector& dq_most, const JointLimits& limits) noexcept {
  JointVector dq_c{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double q = reference.q_d[i];
    const double e = goal[i] - q;
    const double speed =
        std::min({dq_most[i], std::sqrt(limits.ddq_max[i] * std::abs(e)), kGain * std::abs(e),
                  kShareOfLimit * limits.VelocityLimit(i, q, e)});
    dq_c[i] = std::copysign(speed, e);
  }
  reference::ClientLimits most;
  for (std::size_t i = 0; i < kJoints; ++i) {
    most.dq_max[i] = std::min(limits.dq_max[i], dq_most[i]);
  }
  most.ddq_max = limits.ddq_max;
  most.dddq_max = limits.dddq_max;
  return reference.AfterVelocity(
      reference::LimitJointVelocity(dq_c, reference.q_d, reference.dq_d, reference.ddq_d, most));
}

}  // namespace twin::onboard

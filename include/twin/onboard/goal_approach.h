#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// One cycle of INT's way to the goal of an asynchronous position motion (FCI protocol 10), joint
/// by joint: with e the distance to the goal, V the velocity that the client allows, A the limit of
/// acceleration and u the velocity limit at q_d (JointLimits::UpperVelocity),
///   dq_c = sign(e) min(V, sqrt(A |e|), 10 |e| 1/s, 0.95 u),
/// passed through the rate limiter that keeps velocity, acceleration and jerk in their limits
/// (reference::LimitJointVelocity). So the arm brakes with half of A, and the last millimetres take
/// some tenths of a second. A new goal is taken at any time. How the robot plans these motions is
/// not public: a decision.
///
/// Threads: any. Real-time: noexcept, O(1), allocates nothing.
///
/// @param goal  rad. @param dq_most  V, rad/s. @returns the reference one cycle later.
[[nodiscard]] JointReference ApproachStep(const JointReference& reference, const JointVector& goal,
                                          const JointVector& dq_most,
                                          const JointLimits& limits) noexcept TWIN_REALTIME;

}  // namespace twin::onboard

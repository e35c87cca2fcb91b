#pragma once

#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// Brings a moving reference to rest, joint by joint, within acceleration and jerk limits: what INT
/// does after a reflex and on StopMove.
///
/// With d = J T the largest change of acceleration per cycle, an acceleration x against the motion
/// that is then ramped back to zero takes off the velocity
///   T S(x),  S(x) = x + (x - d) + (x - 2d) + ... (positive terms).
/// Each cycle takes the x with T S(x) = |dq_d|, limited to A and to a change of d. S is piecewise
/// linear and rising, so x has a closed form, and the last cycles end at rest exactly: dq_d = 0,
/// ddq_d = 0. A reference that is still accelerating first loses its acceleration at the rate d.
/// Position limits are not looked at: the stop is as short as the other limits allow.
///
/// Threads: any. Real-time: noexcept, O(A/d), allocates nothing.
///
/// @param reference  inside the limits.
/// @returns the reference one cycle later.
[[nodiscard]] JointReference StopStep(const JointReference& reference,
                                      const JointLimits& limits) noexcept TWIN_REALTIME;

}  // namespace twin::onboard

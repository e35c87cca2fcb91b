#pragma once

#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// One step of a stop, which brings a moving reference to rest, joint by joint, within acceleration
/// and jerk limits. INT uses it after a reflex and on StopMove.
///
/// With d = J T the largest change of acceleration per cycle, an acceleration x against the motion
/// that then ramps back to zero reduces the velocity by
///   T S(x),  S(x) = x + (x - d) + (x - 2d) + ... (positive terms).
/// Each cycle uses the x with T S(x) = |dq_d|, limited to A and to a change of d. S is piecewise
/// linear and rising, so x has a closed form, and the last cycles end exactly at rest: dq_d = 0,
/// ddq_d = 0. An accelerating reference first reduces its acceleration at the rate d. Position
/// limits are ignored: the stop is as short as the other limits allow.
///
/// Threads: any. Real-time: noexcept, O(A/d), allocates nothing.
///
/// @param reference  within the limits.
/// @returns the reference one cycle later.
[[nodiscard]] JointReference StopStep(const JointReference& reference,
                                      const JointLimits& limits) noexcept TWIN_REALTIME;

}  // namespace twin::onboard

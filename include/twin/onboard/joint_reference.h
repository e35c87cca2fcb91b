#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"

namespace twin::onboard {

/// INT's joint reference with the derivatives that INT forms: backward differences over one cycle,
/// T = 1 ms. Source: FCI protocol 5, conditions and packet loss.
///
/// A value type; all functions are pure, real-time, and for any thread.
struct JointReference {
  JointVector q_d{};     ///< rad
  JointVector dq_d{};    ///< rad/s
  JointVector ddq_d{};   ///< rad/s^2
  JointVector dddq_d{};  ///< rad/s^3; result of the last step; the next step does not use it

  /// After a commanded position: dq = (q_c - q_d)/T, ddq = (dq - dq_d)/T, dddq = (ddq - ddq_d)/T.
  [[nodiscard]] JointReference AfterPosition(const JointVector& q_c) const noexcept TWIN_REALTIME;

  /// After a commanded velocity: ddq = (dq_c - dq_d)/T, dddq = (ddq - ddq_d)/T, q = q_d + T dq_c.
  [[nodiscard]] JointReference AfterVelocity(const JointVector& dq_c) const noexcept TWIN_REALTIME;

  /// After an acceleration, used by INT's own stops: dq = dq_d + T ddq_c, q = q_d + T dq.
  [[nodiscard]] JointReference AfterAcceleration(const JointVector& ddq_c) const noexcept
      TWIN_REALTIME;

  /// Without a command, holds the acceleration: dq += T ddq_d, q += T dq; the jerk is zero.
  [[nodiscard]] JointReference AfterLoss() const noexcept TWIN_REALTIME;

  /// Whether velocity and acceleration are zero.
  [[nodiscard]] bool AtRest() const noexcept;

  /// At rest at q.
  [[nodiscard]] static JointReference Rest(const JointVector& q) noexcept;
};

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

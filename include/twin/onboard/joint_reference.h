#pragma once

#include "twin/core/joint_vector.h"
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

}  // namespace twin::onboard

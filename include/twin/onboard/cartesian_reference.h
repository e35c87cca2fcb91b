#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// Commanded Cartesian reference with the derivatives that INT forms: backward differences over one
/// cycle, T = 1 ms. The rotational velocity is log(R_c R_last^T) / T in base axes. Twists are [v;
/// w] of the origin of EE in base axes, m/s and rad/s. Source: FCI protocol 5, conditions and
/// packet loss.
///
/// A value type; all functions are pure, real-time, and for any thread.
struct CartesianReference {
  Transform O_T_EE_c = kIdentityTransform;
  Vector6 O_dP_EE_c{};
  Vector6 O_ddP_EE_c{};
  Vector6 O_dddP_EE_c{};  ///< result of the last step; the next step does not use it
  Elbow elbow_c{};        ///< angle of joint 3, rad, and sign of the flip
  double delbow_c = 0;    ///< rad/s
  double ddelbow_c = 0;   ///< rad/s^2
  double dddelbow_c = 0;  ///< rad/s^3

  /// Returns the reference one cycle later with O_T_EE commanded; twist, acceleration and jerk are
  /// differences over T. The elbow is not advanced: call WithElbow or WithElbowOf next.
  /// @pre O_T_EE is rigid.
  [[nodiscard]] CartesianReference AfterPose(const Transform& O_T_EE) const noexcept TWIN_REALTIME;
  /// Returns the reference one cycle later with a twist commanded: integrates the pose, the
  /// rotation by exp(w T) from the left. The elbow as in AfterPose.
  [[nodiscard]] CartesianReference AfterTwist(const Vector6& O_dP_EE) const noexcept TWIN_REALTIME;
  /// Returns the reference one cycle later without a command: holds the acceleration of pose and
  /// elbow; the jerks are zero.
  [[nodiscard]] CartesianReference AfterLoss() const noexcept TWIN_REALTIME;

  /// The same with a commanded elbow angle, after AfterPose or AfterTwist.
  /// @param before  the reference of the cycle before.
  [[nodiscard]] CartesianReference WithElbow(
      const Elbow& elbow, const CartesianReference& before) const noexcept TWIN_REALTIME;
  /// The same with the elbow of the joints, when no elbow is commanded.
  [[nodiscard]] CartesianReference WithElbowOf(const JointReference& joints) const noexcept
      TWIN_REALTIME;

  /// Whether velocity and acceleration of pose and elbow are exactly zero.
  [[nodiscard]] bool AtRest() const noexcept;
  [[nodiscard]] static CartesianReference Rest(const Transform& O_T_EE,
                                               const Elbow& elbow) noexcept;
};

}  // namespace twin::onboard

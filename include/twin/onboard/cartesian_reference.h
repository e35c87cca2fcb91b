#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// What a Cartesian motion generator was commanded, with the derivatives INT forms itself: backward
/// differences over one cycle, T = 1 ms. The rotation's velocity is log(R_c R_last^T) / T, base
/// axes. Twists are [v; w] of the origin of EE in base axes, m/s and rad/s. Source: FCI protocol 5,
/// conditions and packet loss.
///
/// A value type; all functions are pure, real-time, and for any thread.
struct CartesianReference {
  Transform O_T_EE_c = kIdentityTransform;
  Vector6 O_dP_EE_c{};
  Vector6 O_ddP_EE_c{};
  Vector6 O_dddP_EE_c{};  ///< how O_ddP_EE_c came about, does not enter the next step
  Elbow elbow_c{};        ///< angle of joint 3, rad, and sign of the flip
  double delbow_c = 0;    ///< rad/s
  double ddelbow_c = 0;   ///< rad/s^2
  double dddelbow_c = 0;  ///< rad/s^3

  /// A commanded pose. @pre rigid. The elbow stays as it is until one of the two below gives it.
  [[nodiscard]] CartesianReference AfterPose(const Transform& O_T_EE) const noexcept TWIN_REALTIME;
  /// A commanded twist: the pose goes on by it, the rotation by exp(w T) from the left. The elbow
  /// as with a pose.
  [[nodiscard]] CartesianReference AfterTwist(const Vector6& O_dP_EE) const noexcept TWIN_REALTIME;
  /// No command: the acceleration is held, of pose and elbow; the jerks are zero.
  [[nodiscard]] CartesianReference AfterLoss() const noexcept TWIN_REALTIME;

  /// The same with a commanded elbow angle, after one of the first two.
  /// @param before  the reference of the cycle before.
  [[nodiscard]] CartesianReference WithElbow(
      const Elbow& elbow, const CartesianReference& before) const noexcept TWIN_REALTIME;
  /// The same with the elbow that the joints have, no elbow being commanded.
  [[nodiscard]] CartesianReference WithElbowOf(const JointReference& joints) const noexcept
      TWIN_REALTIME;

  /// Neither velocity nor acceleration left.
  [[nodiscard]] bool AtRest() const noexcept;
  [[nodiscard]] static CartesianReference Rest(const Transform& O_T_EE,
                                               const Elbow& elbow) noexcept;
};

}  // namespace twin::onboard

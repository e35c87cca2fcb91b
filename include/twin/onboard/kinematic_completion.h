#pragma once

#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// Kinematic completion: numerically solves, once per cycle, for the joint positions that reach the
/// commanded pose of EE (and elbow, if commanded), starting from those of the cycle before.
///
/// With an elbow, joint 3 takes the commanded angle and the other six joints reach the pose.
/// Without, the joints take the smallest step that reaches it (least squares, equal weights). This
/// is smooth but not cyclic: a closed path of the hand may leave the elbow elsewhere. The robot's
/// use of the redundancy is not public; ours is a decision.
///
/// Away from singularities FK(q_d) equals the commanded pose up to rounding. Where the dexterity s
/// (model::InverseKinematics) is below kDampedBelow, inverse kinematics is damped, and joint 4 is
/// repelled from the flip angle (greatest extension) within kKeptClear by
///   dq_4 = -+ kRepulsion (1 - |q_4 - q_flip| / kKeptClear)^3,
/// so that the elbow never flips and a stretched arm can always come back; the part of the command
/// beyond reach is not executed. The remaining pose error, the lag, decays with the time constant
/// kCatchUpTime, at no more than kCatchUpSpeed, near singularities and after; it is zero before the
/// first one and decays to exactly zero. Steps of q_d enter and leave this region as smoothly as
/// the commands. Joints may still exceed their limits: the check after inverse kinematics then ends
/// the motion, as on the robot. All bounds are decisions; the robot's are not public ("modified
/// near singularities"). Source: FCI protocol 5, kinematics completion.
///
/// A motion at rest stays exactly at rest: steps below 1e-11 rad are withheld until they add up to
/// more.
///
/// Threads: INT's. Real-time: noexcept, bounded, allocates nothing. Finite input of any value gives
/// finite output.
class KinematicCompletion {
 public:
  static constexpr double kDampedBelow = 0.04;    ///< dexterity; q_4 0.3 rad from the flip angle
  static constexpr double kSingularBelow = 0.02;  ///< dexterity; no Cartesian motion starts there
  static constexpr double kKeptClear = 0.05;      ///< rad, from joint 4 to the flip angle
  static constexpr double kRepulsion = 2;         ///< rad/s
  static constexpr double kCatchUpTime = 0.2;     ///< s
  static constexpr double kCatchUpSpeed = 0.1;    ///< m/s, rad/s

  explicit KinematicCompletion(const Transform& F_T_EE = kIdentityTransform) noexcept;

  /// Displacement from the pose of EE to the commanded one (model::Displacement).
  using Lag = Vector6;

  struct Step {
    JointVector q_d{};
    Transform O_T_EE_d = kIdentityTransform;  ///< FK(q_d)
    Vector6 O_dP_EE_d{};                      ///< J(q_d) times the backward difference of q_d
    Lag lag{};                                ///< input of the next cycle
  };
  /// One cycle.
  /// @param from      joints of the last cycle. @param lag  of the last cycle; zero at the start.
  /// @param O_T_EE_c  commanded pose; rigid within 1e-5, its nearest rigid transform is used.
  /// @param elbow     commanded angle of joint 3, rad.
  [[nodiscard]] Step Complete(const JointReference& from, const Lag& lag, const Transform& O_T_EE_c,
                              const std::optional<double>& elbow) const noexcept TWIN_REALTIME;

  /// Whether no Cartesian motion can start at q: dexterity below kSingularBelow, or joint 4 within
  /// kKeptClear of the flip angle. A running motion may enter such configurations.
  [[nodiscard]] bool IsSingular(const JointVector& q) const noexcept TWIN_REALTIME;

 private:
  [[nodiscard]] Vector6 ErrorAtFlange(const Transform& O_T_EE, const Transform& O_T_EE_c,
                                      const Lag& lag) const noexcept;

  Transform F_T_EE_;
  Vector3 EE_p_F_;  ///< origin of the flange in EE
};

}  // namespace twin::onboard

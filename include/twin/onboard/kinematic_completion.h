#pragma once

#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"
#include "twin/onboard/joint_reference.h"

namespace twin::onboard {

/// Kinematic completion: from the commanded pose of EE (and the elbow, when commanded) to joint
/// positions, one cycle at a time, numerically, from the joints of the cycle before.
///
/// With an elbow, joint 3 is the commanded angle and the other six joints reach the pose. Without,
/// the joints make the smallest step that reaches it (least squares, all joints alike). That is
/// smooth, but not cyclic: a closed path of the hand need not bring the elbow back to where it
/// was. How the robot itself uses the redundancy is not public; this is a decision.
///
/// Where the arm is not singular, FK(q_d) is the commanded pose to rounding. Where its dexterity s
/// (model::InverseKinematics) is below kDampedBelow, inverse kinematics is damped, and joint 4
/// is kept from the flip angle (greatest extension) by
///   dq_4 = -+ kRepulsion (1 - |q_4 - q_flip| / kKeptClear)^3   within kKeptClear,
/// so that the elbow never flips and an arm that was stretched can always come back: what the
/// commanded pose asks beyond reach stays undone. The pose that is left behind, the lag, comes down
/// with the time constant kCatchUpTime, at no more than kCatchUpSpeed, near singularities and
/// after; it is zero before the first and dies out to exactly zero. Steps of q_d go smoothly into
/// and out of all this, as smoothly as the commands, but joints may still have to be too fast for
/// their limits: the check after inverse kinematics ends such motions, as on the robot.
/// All bounds are decisions; the robot's own are not public ("modified near singularities").
/// Source: FCI protocol 5, kinematics completion.
///
/// A motion that rests rests exactly: steps below 1e-11 rad are not made before they add up to
/// more.
///
/// Threads: INT's. Real-time: noexcept, bounded, allocates nothing. Finite input, of any value,
/// gives finite output.
class KinematicCompletion {
 public:
  static constexpr double kDampedBelow = 0.04;    ///< dexterity; q_4 0.3 rad from the flip angle
  static constexpr double kSingularBelow = 0.02;  ///< dexterity; no Cartesian motion starts there
  static constexpr double kKeptClear = 0.05;      ///< rad, of joint 4 from the flip angle
  static constexpr double kRepulsion = 2;         ///< rad/s
  static constexpr double kCatchUpTime = 0.2;     ///< s
  static constexpr double kCatchUpSpeed = 0.1;    ///< m/s, rad/s

  explicit KinematicCompletion(const Transform& F_T_EE = kIdentityTransform) noexcept;

  /// How far the pose of EE is behind the commanded one, as model::Displacement says it.
  using Lag = Vector6;

  struct Step {
    JointVector q_d{};
    Transform O_T_EE_d = kIdentityTransform;  ///< FK(q_d)
    Vector6 O_dP_EE_d{};                      ///< J(q_d) times the backward difference of q_d
    Lag lag{};                                ///< goes into the next cycle
  };
  /// One cycle.
  /// @param from      joints of the cycle before. @param lag  of that cycle; zero at the start.
  /// @param O_T_EE_c  commanded pose; rigid within 1e-5, its nearest rigid transform counts.
  /// @param elbow     commanded angle of joint 3, rad.
  [[nodiscard]] Step Complete(const JointReference& from, const Lag& lag, const Transform& O_T_EE_c,
                              const std::optional<double>& elbow) const noexcept TWIN_REALTIME;

  /// Whether no Cartesian motion can start at q: dexterity below kSingularBelow, or joint 4 within
  /// kKeptClear of the flip angle. A motion that runs may go on into such places.
  [[nodiscard]] bool IsSingular(const JointVector& q) const noexcept TWIN_REALTIME;

 private:
  [[nodiscard]] Vector6 ErrorAtFlange(const Transform& O_T_EE, const Transform& O_T_EE_c,
                                      const Lag& lag) const noexcept;

  Transform F_T_EE_;
  Vector3 EE_p_F_;  ///< origin of the flange in EE
};

}  // namespace twin::onboard

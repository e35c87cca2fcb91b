#pragma once

#include <string_view>

#include <Eigen/Core>

#include "twin/core/limits.h"
#include "twin/core/realtime.h"

namespace twin::reference {

/// Velocities of a point, or of a rotation, whose speed, acceleration and jerk (Euclidean norms)
/// can be kept at all times, whichever commands are lost, as long as at most n consecutive ones
/// are. The counterpart of ViableAxis without a range of positions:
///   a command arrives: a+ = a + T j,  v+ = v + T a+,   |j| <= J;    one is lost: j = 0.
///
/// Braking reduces the acceleration along its own direction, a+ = (|a| - min(T J, |a|)) a/|a|. If n
/// commands are lost before each one that arrives, the velocity gained along a/|a| is
///   G(x) = n T x + T x' + G(x'),   x' = max(x - T J, 0),   G(0) = 0,
/// and a state is viable when |a| <= A, |v| <= V and |v + G(|a|) a/|a|| <= V. All velocities in
/// between lie between these two, and a ball is convex. Proof and its limitations:
/// src/reference/VIABILITY.md, "Poses".
///
/// The set is not the largest one: other ways of braking may keep the limits from further states.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing; G takes as many
/// steps as commands are needed from A to rest, two for a Panda.
class ViableTwist {
 public:
  /// @param lost  n, in [0, ViableAxis::kMostLost]. @param name  of the motion, for messages.
  /// @throws InputError for bounds that are not finite or positive, an n out of range, or V < G(A),
  /// which the losses alone would exceed; the text says what would be enough.
  ViableTwist(const CartesianBound& bound, int lost, std::string_view name);

  /// Whether a state is viable. @param v, a  m/s and m/s^2, or rad/s and rad/s^2; one frame.
  [[nodiscard]] bool Contains(const Eigen::Vector3d& v,
                              const Eigen::Vector3d& a) const noexcept TWIN_REALTIME;

  /// Whether velocity v_c may follow (v, a): jerk and next state are within bounds.
  [[nodiscard]] bool Allows(const Eigen::Vector3d& v, const Eigen::Vector3d& a,
                            const Eigen::Vector3d& v_c) const noexcept TWIN_REALTIME;

  /// The velocity to command: exactly the requested one if allowed; else the nearest allowed one
  /// between braking and the request saturated to acceleration and jerk. From a state outside the
  /// set: braking.
  [[nodiscard]] Eigen::Vector3d Nearest(const Eigen::Vector3d& v, const Eigen::Vector3d& a,
                                        const Eigen::Vector3d& wish) const noexcept TWIN_REALTIME;

  /// Braking: reduces the acceleration along its own direction.
  [[nodiscard]] Eigen::Vector3d Braked(const Eigen::Vector3d& v,
                                       const Eigen::Vector3d& a) const noexcept TWIN_REALTIME;

  /// Towards rest, without overshoot: acceleration min(A, |v| / 4T) against v, as far as allowed.
  [[nodiscard]] Eigen::Vector3d Slowed(const Eigen::Vector3d& v,
                                       const Eigen::Vector3d& a) const noexcept TWIN_REALTIME;

  /// The enforced bounds: a millionth inside the given ones.
  [[nodiscard]] const CartesianBound& kept() const noexcept { return kept_; }

 private:
  [[nodiscard]] double Gathered(double acceleration) const noexcept;

  int lost_;
  CartesianBound kept_;
};

}  // namespace twin::reference

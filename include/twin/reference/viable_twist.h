#pragma once

#include <string_view>

#include <Eigen/Core>

#include "twin/core/limits.h"
#include "twin/core/realtime.h"

namespace twin::reference {

/// Velocities of a point, or of a rotation, whose speed, acceleration and jerk (Euclidean norms)
/// can be kept for ever, whatever commands are lost, as long as no more than n are lost in a row.
/// What ViableAxis is for a joint, without a range of positions:
///   a command arrives   a+ = a + T j,  v+ = v + T a+,   |j| <= J;    one is lost: j = 0.
///
/// Braking takes the acceleration back along its own direction, a+ = (|a| - min(T J, |a|)) a/|a|.
/// The velocity which that gathers when n commands are lost before each one that arrives, along
/// a/|a|, is
///   G(x) = n T x + T x' + G(x'),   x' = max(x - T J, 0),   G(0) = 0,
/// and a state is viable when |a| <= A, |v| <= V and |v + G(|a|) a/|a|| <= V. On the way there the
/// velocity is between these two, and a ball is convex. Proof, and what it does not say:
/// src/reference/VIABILITY.md, "Poses".
///
/// Not the largest such set: another way to brake may do where this one does not.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing; G takes as many
/// steps as there are commands from A to rest, two for a Panda.
class ViableTwist {
 public:
  /// @param lost  n, in [0, ViableAxis::kMostLost]. @param name  of the motion, for messages.
  /// @throws InputError for bounds that are not finite or positive, an n out of range, and where V
  /// is gathered within the losses alone, V < G(A): says what would be enough.
  ViableTwist(const CartesianBound& bound, int lost, std::string_view name);

  /// Whether a state is viable. @param v, a  m/s and m/s^2, or rad/s and rad/s^2; one frame.
  [[nodiscard]] bool Contains(const Eigen::Vector3d& v,
                              const Eigen::Vector3d& a) const noexcept TWIN_REALTIME;

  /// Whether velocity v_c may follow upon (v, a): jerk and what it leads to are within bounds.
  [[nodiscard]] bool Allows(const Eigen::Vector3d& v, const Eigen::Vector3d& a,
                            const Eigen::Vector3d& v_c) const noexcept TWIN_REALTIME;

  /// The velocity to command: the wished one, bit for bit, where it is allowed; else what is
  /// allowed and nearest to it on the way from braking to the wish as saturated to acceleration and
  /// jerk. From a state outside the set: braking.
  [[nodiscard]] Eigen::Vector3d Nearest(const Eigen::Vector3d& v, const Eigen::Vector3d& a,
                                        const Eigen::Vector3d& wish) const noexcept TWIN_REALTIME;

  /// Braking: the acceleration taken back along its own direction.
  [[nodiscard]] Eigen::Vector3d Braked(const Eigen::Vector3d& v,
                                       const Eigen::Vector3d& a) const noexcept TWIN_REALTIME;

  /// Towards rest, without overshoot: acceleration min(A, |v| / 4T) against v, as far as it is
  /// allowed.
  [[nodiscard]] Eigen::Vector3d Slowed(const Eigen::Vector3d& v,
                                       const Eigen::Vector3d& a) const noexcept TWIN_REALTIME;

  /// The bounds that are kept: a millionth inside those given.
  [[nodiscard]] const CartesianBound& kept() const noexcept { return kept_; }

 private:
  [[nodiscard]] double Gathered(double acceleration) const noexcept;

  int lost_;
  CartesianBound kept_;
};

}  // namespace twin::reference

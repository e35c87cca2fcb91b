#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/lab_limits.h"

namespace twin::teleop {

class TurnBounds;

/// What limits a led motion.
enum class Bound : std::uint8_t {
  kNone,
  kWorkspace,   ///< box or shell of the workspace
  kPress,       ///< lead of the reference over the end effector
  kJointEnd,    ///< end of a joint's range
  kJointSpeed,  ///< a joint would turn too fast
  kSingular,    ///< the arm loses a direction of motion
  kSelf,        ///< the arm would touch itself
  kScene,       ///< the robot is close to a fixed body of the scene
  kRegion,      ///< end of a region of the lab's limits
  kForce,       ///< the lab's cap on the external force
  kTorque,      ///< the lab's cap on a joint's external torque
};

/// A bound, and the joint (1 to 7) it belongs to, 0 for none. Trivially copyable.
struct ActiveBound {
  Bound bound = Bound::kNone;
  std::uint8_t joint = 0;
  std::array<char, model::LimitRegion::kLongestName + 1> region{};  ///< name; ends with a zero
  bool operator==(const ActiveBound&) const = default;
};

/// "joint 4 is close to the end of its range"; for people. Empty for Bound::kNone.
[[nodiscard]] std::string Describe(const ActiveBound& active);

/// A twist that bounds allow.
struct AllowedTwist {
  Vector6 u{};             ///< u', m/s and rad/s
  ActiveBound strongest;   ///< the bound that removed most of u, none if u is allowed
  bool meets_all = false;  ///< false if the bounds contradict each other
};

/// Linear bounds a . u <= b of a twist u, and the closest twist that satisfies them:
///   min |D^-1 (u' - u)|^2   subject to   a_k . u' <= b_k,   |v'| <= V,   |w'| <= W,
/// u' = (v', w'), D = diag(V, V, V, W, W, W).
/// Motion along a bound stays free. A negative b_k asks for motion away from it. A translation or a
/// rotation of zero stays zero.
///
/// Solved by Hildreth's method (dual coordinate ascent), the two balls by Dykstra's, with a fixed
/// number of sweeps. If not all bounds can be met, none is passed farther: negative b_k count as
/// zero, and what the sweeps leave of a bound scales the twist. Sources: Hildreth, "A quadratic
/// programming procedure", Naval Research Logistics Quarterly 1957; Boyle and Dykstra, "A method
/// for finding projections onto the intersection of convex sets in Hilbert spaces", 1986.
///
/// Threads: one. Real-time: noexcept, does not allocate, O(bounds).
class TwistBounds {
 public:
  static constexpr std::size_t kMost = 72;  ///< later bounds are dropped

  /// @param along  V, m/s. @param about  W, rad/s; the weights of translation and rotation.
  TwistBounds(double along, double about) noexcept : D_{along, along, along, about, about, about} {}

  void Clear() noexcept TWIN_REALTIME { count_ = 0; }
  /// Adds a . u <= b. Ignored if it is not finite.
  void Add(const Vector6& a, double b, ActiveBound bound) noexcept TWIN_REALTIME;

  /// Adds these bounds to those of a joint's speed s, for u = s `per_turn`.
  void AddTo(TurnBounds& bounds, const Vector6& per_turn) const noexcept TWIN_REALTIME;

  [[nodiscard]] AllowedTwist Closest(const Vector6& u) const noexcept TWIN_REALTIME;

  /// D.
  [[nodiscard]] const Vector6& scale() const noexcept { return D_; }

 private:
  using EigenVector6 = Eigen::Matrix<double, 6, 1>;
  /// Projects the scaled twist x onto a . x <= max(b, least) and both unit balls. @returns what
  /// removed most of it.
  ActiveBound Project(EigenVector6& x, const EigenVector6& commanded, double least,
                      int sweeps) const noexcept;
  /// Share of the scaled twist x with which no bound is passed; a negative b counts as zero.
  [[nodiscard]] double LargestShare(const EigenVector6& x) const noexcept;

  /// Of the scaled twist D^-1 u.
  struct Row {
    Vector6 a;
    double b;
    ActiveBound bound;
  };
  const Vector6 D_;
  std::array<Row, kMost> rows_{};
  std::size_t count_ = 0;
};

}  // namespace twin::teleop

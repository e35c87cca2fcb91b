#pragma once

#include <array>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/reference/resampler.h"

namespace twin::reference {

/// A source's reference in four cycles, newest first: in the commanded cycle, r(k+1), in the
/// answered state, r(k), and in the two before. From a Resampler.
template <typename Position>
using Played = std::array<Position, Resampler::kPlayed>;

/// A reference generator that follows its source exactly while the robot accepts every command.
/// After losses it rejoins the source with bounded velocity, acceleration and jerk, in place of the
/// paper's constant lambda. For joints; RejoiningPoseGenerator is for poses.
///
/// With r the source's reference and its backward differences, the error of the robot's reference,
///   e = q_d - r,   e' = dq_d - r',   e'' = ddq_d - r''       (zero if no command was lost),
/// is brought to zero by a cascade of saturations, fastest inside:
///   v = -sign(e) min(w1 |e|, sqrt(a (2 |e| - a / w1^2)), V_c),   a = 0.4 A_c
///   b = sat(w2 (v - e'), A_c),   j = sat(w3 (b - e''), J_c),
///   q_c = r(k+1) + e + T (e' + T (e'' + T j)).
/// The bounds are the source's remainder of V and A, at least a fixed share, and a share of J:
///   V_c = max(0.3 V, 0.9 V - |r'|),   A_c = max(0.4 A, 0.9 A - |r''|),   J_c = 0.4 J.
/// The braking deceleration, 0.4 A_c, stays below the least A_c, so that it does not overshoot when
/// the source starts to accelerate. So an admissible source is followed without lag or filter, and
/// after a burst of losses the reference brakes and returns within the bounds, without overshoot;
/// lambda = 1e-3 takes seconds regardless of the bounds.
///
/// It needs a source without sampling jitter, from a Resampler. It does not enforce limits on the
/// sum of r and correction; the ViabilityFilter behind it does.
///
/// The paper leaves a saturated correction open; law and gains are decisions.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing, O(1).
class RejoiningGenerator {
 public:
  /// Shares of the joints' limits available to the correction for any source: of the velocity, and
  /// of acceleration and jerk.
  static constexpr double kVelocityShare = 0.3;
  static constexpr double kShare = 0.4;
  /// Share of the velocity and acceleration limits for source and correction together, where it
  /// exceeds those above.
  static constexpr double kMostShare = 0.9;

  /// @pre limits are valid.
  explicit RejoiningGenerator(const JointLimits& limits) noexcept;

  /// @param r  rad. @param q_d, dq_d, ddq_d  the robot's reference in the answered state.
  /// @returns the position to command, rad.
  [[nodiscard]] JointVector Next(const Played<JointVector>& r, const JointVector& q_d,
                                 const JointVector& dq_d,
                                 const JointVector& ddq_d) const noexcept TWIN_REALTIME;

 private:
  std::array<CartesianBound, kJoints> limits_{};  ///< per joint, rad
};

/// RejoiningGenerator for poses: the same law for the end effector's translation and rotation, with
/// three components each and saturated norms, within kPoseShare of the limits, since the joints
/// behind the robot's inverse kinematics cannot follow the full limits. Rotation errors are
/// rotation vectors in base axes.
///
/// Threads, real-time: as RejoiningGenerator.
class RejoiningPoseGenerator {
 public:
  /// Determined by measurement: src/reference/CHAINS.md.
  static constexpr double kPoseShare = 0.3;

  /// @pre limits are valid.
  explicit RejoiningPoseGenerator(const CartesianLimits& limits) noexcept;

  /// @param state  the answered one: its O_T_EE_c and derivatives are used.
  /// @returns the pose to command.
  [[nodiscard]] Transform Next(const Played<Transform>& r,
                               const RobotState& state) const noexcept TWIN_REALTIME;

 private:
  CartesianLimits limits_;
};

}  // namespace twin::reference

#pragma once

#include <array>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/reference/resampler.h"

namespace twin::reference {

/// A source's reference in four cycles, newest first: of the cycle commanded, r(k+1), of the state
/// answered, r(k), and of the two before. From a Resampler.
template <typename Position>
using Played = std::array<Position, Resampler::kPlayed>;

/// A reference generator that follows its source exactly while the robot takes every command, and
/// otherwise rejoins it by a motion with bounded velocity, acceleration and jerk, in place of the
/// paper's constant lambda. Of joints here, of poses in RejoiningPoseGenerator.
///
/// With r the source's reference and its backward differences, what the robot's reference lacks of
/// it is
///   e = q_d - r,   e' = dq_d - r',   e'' = ddq_d - r''       (zero, if every command was taken)
/// and is brought to zero by a cascade of saturations, fastest inside:
///   v = -sign(e) min(w1 |e|, sqrt(a (2 |e| - a / w1^2)), V_c),   a = 0.4 A_c
///   b = sat(w2 (v - e'), A_c),   j = sat(w3 (b - e''), J_c),
///   q_c = r(k+1) + e + T (e' + T (e'' + T j)).
/// Its bounds are what the source leaves of the limits V and A, and no less than a share of them:
///   V_c = max(0.3 V, 0.9 V - |r'|),   A_c = max(0.4 A, 0.9 A - |r''|),   J_c = 0.4 J.
/// Braking, 0.4 A_c, stays below the least A_c, so that it does not overshoot when the source
/// begins to accelerate. So a source that is itself admissible is followed without lag or filter,
/// and a burst of losses costs what it takes to brake and return within the bounds, without
/// overshoot; lambda = 1e-3 returns in seconds whatever there is room for.
///
/// It asks for a source without sampling jitter: behind a Resampler. It keeps no limits: of r and
/// correction together, the ViabilityFilter behind it does.
///
/// The paper leaves a saturated correction open; law and gains are our decision.
///
/// Threads: constant after construction. Real-time: noexcept, allocates nothing, O(1).
class RejoiningGenerator {
 public:
  /// Shares of the joints' limits that the correction may take of any source: of the velocity, and
  /// of acceleration and jerk.
  static constexpr double kVelocityShare = 0.3;
  static constexpr double kShare = 0.4;
  /// Share of the limits of velocity and acceleration that source and correction may take together,
  /// where the source leaves more than those.
  static constexpr double kMostShare = 0.9;

  /// @pre limits are valid.
  explicit RejoiningGenerator(const JointLimits& limits) noexcept;

  /// @param r  rad. @param q_d, dq_d, ddq_d  of the state being answered.
  /// @returns the position to command, rad.
  [[nodiscard]] JointVector Next(const Played<JointVector>& r, const JointVector& q_d,
                                 const JointVector& dq_d,
                                 const JointVector& ddq_d) const noexcept TWIN_REALTIME;

 private:
  std::array<CartesianBound, kJoints> limits_{};  ///< of each joint, rad
};

/// RejoiningGenerator for poses: the same law for the end effector's translation and rotation, with
/// three components each and norms saturated, in kPoseShare of the limits: all of them are more
/// than the joints behind the robot's inverse kinematics can do. Errors of rotation are rotation
/// vectors, base axes.
///
/// Threads, real-time: as RejoiningGenerator.
class RejoiningPoseGenerator {
 public:
  /// Found by measurement: src/reference/CHAINS.md.
  static constexpr double kPoseShare = 0.3;

  /// @pre limits are valid.
  explicit RejoiningPoseGenerator(const CartesianLimits& limits) noexcept;

  /// @param state  that is answered: its O_T_EE_c and their differences count.
  /// @returns the pose to command.
  [[nodiscard]] Transform Next(const Played<Transform>& r,
                               const RobotState& state) const noexcept TWIN_REALTIME;

 private:
  CartesianLimits limits_;
};

}  // namespace twin::reference

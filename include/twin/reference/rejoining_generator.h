#pragma once

#include <array>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"

namespace twin::reference {

/// A reference generator in joint space that follows its source exactly while the robot takes every
/// command, and otherwise rejoins it by a motion with bounded velocity, acceleration and jerk, in
/// place of the paper's constant lambda.
///
/// With r(k) the source's reference at state k and its backward differences, what the robot's
/// reference lacks of it is
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
/// Threads: one. Real-time: noexcept, allocates nothing, O(1).
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

  /// A motion begins. @param q_d  rad, of its first state.
  void Reset(const JointVector& q_d) noexcept TWIN_REALTIME;

  /// The source's reference of one more cycle, in order, none left out: of those cycles too in
  /// which no command could be sent.
  void Observe(const JointVector& r) noexcept TWIN_REALTIME;

  /// The command, after the Observe() of the cycle it is for.
  /// @param q_d, dq_d, ddq_d  of the state being answered. @returns rad.
  [[nodiscard]] JointVector Next(const JointVector& q_d, const JointVector& dq_d,
                                 const JointVector& ddq_d) const noexcept TWIN_REALTIME;

 private:
  /// Bounds of one joint, or of its correction.
  struct Bounds {
    double v = 0;
    double a = 0;
    double j = 0;
  };
  /// Of the correction. @param v, a  of the source.
  [[nodiscard]] static Bounds LeftBy(double v, double a, const Bounds& limits) noexcept;
  [[nodiscard]] static double Jerk(double e, double de, double dde, const Bounds& most) noexcept;

  std::array<Bounds, kJoints> limits_{};
  std::array<JointVector, 4> r_{};  ///< newest first: r(k+1), r(k), r(k-1), r(k-2)
};

}  // namespace twin::reference

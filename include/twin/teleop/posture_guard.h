#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/model/arm_model.h"

namespace twin::teleop {

/// Keeps an operator away from configurations that the arm cannot follow: ends of joint ranges and
/// singular postures.
///
/// Predicts the joints a quarter of a second (at most 0.1 rad) ahead along the motion of least
/// norm,
///   dq = J^T (J J^T + d I)^-1 u,   q' = q + dq h,
/// and evaluates each joint's distance from the ends of its range and Yoshikawa's manipulability
/// sqrt(det(J J^T)). A measure that falls, and is below its soft bound, scales the command by a
/// share that reaches zero at its hard bound; the smallest share counts. Motion away from a bound
/// is always free.
///
/// Source of the measure: Yoshikawa, "Manipulability of Robotic Mechanisms", IJRR 1985. The bounds
/// are decisions.
///
/// Threads: any (immutable). Real-time: noexcept, does not allocate.
class PostureGuard {
 public:
  static constexpr double kSoftMargin = 0.20;  ///< of a joint, rad
  static constexpr double kHardMargin = 0.08;
  static constexpr double kSoftManipulability = 0.030;  ///< m^3 (three rows in m, three in rad)
  static constexpr double kHardManipulability = 0.015;

  /// @param arm  must outlive the guard.
  PostureGuard(const model::ArmModel& arm, const JointLimits& limits) noexcept
      : arm_(arm), limits_(limits) {}

  /// @param twist  u, commanded, base axes, m/s and rad/s. @returns the share of u that may be
  /// followed, in [0, 1].
  [[nodiscard]] double Share(const RobotState& state,
                             const Vector6& twist) const noexcept TWIN_REALTIME;

 private:
  const model::ArmModel& arm_;
  const JointLimits limits_;
};

}  // namespace twin::teleop

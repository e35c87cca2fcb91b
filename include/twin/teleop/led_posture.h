#pragma once

#include <cstddef>

#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"
#include "twin/reference/target.h"

namespace twin::teleop {

/// The joints q_r of the arm at its reference x_d, by resolved motion rate:
///   dq_r = B (dx_d + k e) + (I - B J) z,   B = J^T (J J^T + d I)^-1,   q_r+ = q_r + T dq_r,
/// e the error of x(q_r) from x_d. z keeps joints off the ends of their ranges within the arm's
/// redundancy: it is proportional to how far a joint is within kSoftMargin. Where bounds contradict
/// each other it fades out: what it moves could be what is close to a body.
///
/// Or a joint j turns alone at s, and x_d follows:
///   dq_r = s e_j,   dx_d = J dq_r + k (x(q_r) - x_d).
/// Afterwards z fades in, so that dq_r has no step.
///
/// Threads: one. Real-time: noexcept, does not allocate.
class LedPosture {
 public:
  static constexpr double kSoftMargin = 0.3;  ///< rad

  /// @param arm  must outlive the posture.
  LedPosture(const model::ArmModel& arm, const JointLimits& limits) noexcept
      : arm_(arm), limits_(limits) {}

  /// @param q  measured, rad.
  void Begin(const JointVector& q) noexcept TWIN_REALTIME {
    now_ = {.q = q};
    centring_ = 1;
  }

  /// Advances one period. @param x_d  after it. @param T  s, > 0. @param centres  false fades z
  /// out.
  void Follow(const reference::PoseTarget& x_d, const Transform& F_T_EE, double T,
              bool centres) noexcept TWIN_REALTIME;

  /// The twist of the end effector per speed of a joint that turns alone, from 0.
  [[nodiscard]] Vector6 PerTurn(std::size_t joint,
                                const Transform& F_T_EE) const noexcept TWIN_REALTIME;

  /// Advances one period, in which a joint turns alone. @param joint  from 0. @param speed  rad/s.
  /// @returns the twist with which x_d follows, base axes.
  [[nodiscard]] Vector6 Turn(std::size_t joint, double speed, const Transform& x_d,
                             const Transform& F_T_EE, double T) noexcept TWIN_REALTIME;

  /// q_r and dq_r.
  [[nodiscard]] const reference::JointTarget& now() const noexcept { return now_; }

 private:
  const model::ArmModel& arm_;
  const JointLimits limits_;
  reference::JointTarget now_{};
  double centring_ = 1;  ///< share of z
};

}  // namespace twin::teleop

#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/reference/joint_target.h"

namespace twin::reference {

/// The paper's reference generator in joint space:
///   q_s(k) = q_d(k) + T dq_ext(k) + lambda (q_ext(k) - q_d(k)),
/// q_d the last commanded position from the state packet, q_ext and dq_ext the deposited target and
/// its velocity, T = 1 ms. It continues from what the robot really took, so jitter, late and lost
/// commands do not show up as steps; a stalled source (dq_ext = 0) decays to the last target with
/// time constant T/lambda. No time stamp enters. White noise on q_ext is not removed, only scaled
/// by lambda. Source: the paper's section on reference generation.
///
/// Threads: stateless, any. Real-time: Next() is noexcept, O(1), allocates nothing.
class JointReferenceGenerator {
 public:
  /// @param lambda  correction per cycle, in (0, 1]; the paper uses 1e-3.
  /// @throws InputError naming the value and the range.
  explicit JointReferenceGenerator(double lambda = 1e-3);

  /// @param q_d     rad, of the state being answered.
  /// @param target  q and dq are used.
  /// @returns q_s, rad.
  [[nodiscard]] JointVector Next(const JointVector& q_d,
                                 const JointTarget& target) const noexcept TWIN_REALTIME;

  [[nodiscard]] double lambda() const noexcept { return lambda_; }

 private:
  double lambda_;
};

}  // namespace twin::reference

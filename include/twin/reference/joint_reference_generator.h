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
/// time constant T/lambda. No time stamp enters. Source: the paper's section on reference
/// generation.
///
/// What it does not do. White noise of q_ext is not removed. When the source gives dq_ext itself,
/// the noise's jerk comes out times lambda sqrt(6/20), as its third difference becomes a second one
/// of lambda times it; when dq_ext is formed from the noisy q_ext, the noise comes out whole. And
/// libfranka's low-pass of gain g behind it scales the increment: the velocity follows
/// g (s + lambda/T)/(s + g lambda/T) of the target's; at 100 Hz that is 0.4 to 0.5 of a motion with
/// a period of 2 to 6 s. It belongs off.
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

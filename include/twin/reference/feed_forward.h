#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/deposit_interval.h"
#include "twin/reference/joint_target.h"

namespace twin::reference {

/// Gives a deposited joint position its velocity, at the place where commands are deposited:
///   dq_ext = (q_ext(i) - q_ext(i-1)) / (t(i) - t(i-1)),
/// t the source's own time. Formed where commands are consumed instead, a deposit consumed twice or
/// skipped would become a velocity spike. A source that knows its velocity bypasses this. Source:
/// the paper's section on reference generation.
///
/// Before the second deposit dq_ext = 0. A deposit whose time does not rise keeps the last
/// velocity; the next difference is taken from it all the same, so a source whose clock was set
/// back loses one interval and no more.
///
/// Threads: the depositing thread. Real-time: Next() is noexcept, O(1), allocates nothing.
class FeedForward {
 public:
  /// @param nominal_period  used by kNominal; > 0.
  /// @throws InputError naming the value and the range.
  explicit FeedForward(FeedForwardTime time = FeedForwardTime::kSource,
                       Duration nominal_period = kCycle);

  /// Forgets the last deposit.
  void Reset() noexcept;

  /// @param source_time  when the source sampled q, on its own clock.
  /// @param q            rad.
  /// @returns the target with its velocity formed; ddq zero.
  [[nodiscard]] JointTarget Next(Time source_time, const JointVector& q) noexcept TWIN_REALTIME;

 private:
  DepositInterval interval_;
  JointVector last_q_{};
  JointVector dq_{};
};

}  // namespace twin::reference

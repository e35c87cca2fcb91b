#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/deposit_interval.h"
#include "twin/reference/joint_target.h"

namespace twin::reference {

/// Forms the velocity of a deposited joint position, at the deposit:
///   dq_ext = (q_ext(i) - q_ext(i-1)) / (t(i) - t(i-1)),
/// with t the source's time. If it were formed where commands are consumed, a deposit consumed
/// twice or skipped would become a velocity spike. A source that knows its velocity bypasses this.
/// Source: the paper's section on reference generation.
///
/// Before the second deposit dq_ext = 0. A deposit whose time does not increase keeps the last
/// velocity and is still the base of the next difference, so a source whose clock is set back loses
/// one interval only.
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

  /// @param source_time  sampling time of q on the source's clock.
  /// @param q            rad.
  /// @returns the target with its velocity; ddq is zero.
  [[nodiscard]] JointTarget Next(Time source_time, const JointVector& q) noexcept TWIN_REALTIME;

 private:
  DepositInterval interval_;
  JointVector last_q_{};
  JointVector dq_{};
};

}  // namespace twin::reference

#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/deposit_interval.h"
#include "twin/reference/pose_target.h"

namespace twin::reference {

/// Forms the twist of a deposited pose, at the deposit:
///   O_dP_EE = [p(i) - p(i-1); log(R(i) R(i-1)^T)] / (t(i) - t(i-1)),
/// with t the source's time: FeedForward for poses, with the same rules for the first deposit and
/// for time that does not increase. It takes the shortest rotation between two deposits, so a
/// rotation by more than half a turn per period is misread.
///
/// Threads: the depositing thread. Real-time: Next() is noexcept, O(1), allocates nothing.
class PoseFeedForward {
 public:
  /// @param nominal_period  used by kNominal; > 0.
  /// @throws InputError naming the value and the range.
  explicit PoseFeedForward(FeedForwardTime time = FeedForwardTime::kSource,
                           Duration nominal_period = kCycle);

  /// Forgets the last deposit.
  void Reset() noexcept;

  /// @param source_time  sampling time of the pose on the source's clock.
  /// @param O_T_EE       pose of EE in the base.
  /// @returns the target with its twist.
  [[nodiscard]] PoseTarget Next(Time source_time, const Transform& O_T_EE) noexcept TWIN_REALTIME;

 private:
  DepositInterval interval_;
  Transform last_ = kIdentityTransform;
  Vector6 O_dP_EE_{};
};

}  // namespace twin::reference

#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/reference/target.h"

namespace twin::reference {

/// Time that divides the difference of two deposits.
enum class FeedForwardTime : std::uint8_t {
  kSource,   ///< the source's time between the deposits: the mean velocity over a jittered interval
             ///< is correct to first order
  kNominal,  ///< the source's nominal period: jitter passes unchanged; kept for comparison
};

/// The time between successive deposits of a source, for the feed-forward of joints and poses.
///
/// Threads: the depositing thread. Real-time: Next() is noexcept, O(1), allocates nothing.
class DepositInterval {
 public:
  /// @param nominal_period  used by kNominal; > 0.
  /// @throws InputError naming the value and the range.
  DepositInterval(FeedForwardTime time, Duration nominal_period);

  /// Forgets the last deposit.
  void Reset() noexcept { last_time_.reset(); }

  /// @param source_time  sampling time of this deposit on the source's clock.
  /// @returns the divisor of the difference to the last deposit, s; nullopt for the first deposit
  /// and for one whose time does not increase.
  [[nodiscard]] std::optional<double> Next(Time source_time) noexcept TWIN_REALTIME;

 private:
  FeedForwardTime time_;
  double nominal_s_;
  std::optional<Time> last_time_;
};

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

#pragma once

#include <cstdint>
#include <optional>

#include "twin/core/realtime.h"
#include "twin/core/time.h"

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

}  // namespace twin::reference

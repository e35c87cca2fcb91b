#include "twin/reference/deposit_interval.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::reference {

DepositInterval::DepositInterval(FeedForwardTime time, Duration nominal_period)
    : time_(time), nominal_s_(ToSeconds(nominal_period)) {
  if (nominal_period <= Duration::zero()) {
    throw InputError(fmt::format("feed-forward: the nominal period is {} ns; it must be above 0",
                                 nominal_period.count()));
  }
}

std::optional<double> DepositInterval::Next(Time source_time) noexcept {
  std::optional<double> divisor;
  if (last_time_ && source_time > *last_time_) {
    divisor = time_ == FeedForwardTime::kSource ? ToSeconds(source_time - *last_time_) : nominal_s_;
  }
  last_time_ = source_time;
  return divisor;
}

}  // namespace twin::reference

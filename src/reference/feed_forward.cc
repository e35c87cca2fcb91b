#include "twin/reference/feed_forward.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::reference {

FeedForward::FeedForward(FeedForwardTime time, Duration nominal_period)
    : time_(time), nominal_s_(ToSeconds(nominal_period)) {
  if (nominal_period <= Duration::zero()) {
    throw InputError(fmt::format("feed-forward: the nominal period is {} ns; it must be above 0",
                                 nominal_period.count()));
  }
}

void FeedForward::Reset() noexcept {
  has_last_ = false;
  dq_ = {};
}

JointTarget FeedForward::Next(Time source_time, const JointVector& q) noexcept {
  const Duration elapsed = source_time - last_time_;
  if (has_last_ && elapsed > Duration::zero()) {
    const double divisor = time_ == FeedForwardTime::kSource ? ToSeconds(elapsed) : nominal_s_;
    for (std::size_t j = 0; j < kJoints; ++j) dq_[j] = (q[j] - last_q_[j]) / divisor;
  }
  has_last_ = true;
  last_time_ = source_time;
  last_q_ = q;
  return {q, dq_, {}};
}

}  // namespace twin::reference

#include "twin/reference/feed_forward.h"

namespace twin::reference {

FeedForward::FeedForward(FeedForwardTime time, Duration nominal_period)
    : interval_(time, nominal_period) {}

void FeedForward::Reset() noexcept {
  interval_.Reset();
  dq_ = {};
}

JointTarget FeedForward::Next(Time source_time, const JointVector& q) noexcept {
  if (const auto divisor = interval_.Next(source_time)) {
    for (std::size_t j = 0; j < kJoints; ++j) dq_[j] = (q[j] - last_q_[j]) / *divisor;
  }
  last_q_ = q;
  return {q, dq_, {}};
}

}  // namespace twin::reference

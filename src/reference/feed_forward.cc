#include "twin/reference/feed_forward.h"

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/model/transform.h"

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

PoseFeedForward::PoseFeedForward(FeedForwardTime time, Duration nominal_period)
    : interval_(time, nominal_period) {}

void PoseFeedForward::Reset() noexcept {
  interval_.Reset();
  O_dP_EE_ = {};
}

PoseTarget PoseFeedForward::Next(Time source_time, const Transform& O_T_EE) noexcept {
  if (const auto divisor = interval_.Next(source_time)) {
    const Eigen::Vector3d v = (model::Position(O_T_EE) - model::Position(last_)) / *divisor;
    const Eigen::Vector3d w = model::TurnBetween(last_, O_T_EE) / *divisor;
    O_dP_EE_ = {v[0], v[1], v[2], w[0], w[1], w[2]};
  }
  last_ = O_T_EE;
  return {O_T_EE, O_dP_EE_};
}

}  // namespace twin::reference

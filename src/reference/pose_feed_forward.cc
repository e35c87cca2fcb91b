#include "twin/reference/pose_feed_forward.h"

#include "twin/model/rotation.h"

namespace twin::reference {

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

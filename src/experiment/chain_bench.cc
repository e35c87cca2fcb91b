#include "experiment/chain_bench.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace twin::experiment {
JointVector MiddleOf(const JointLimits& limits) noexcept {
  JointVector middle{};
  for (std::size_t i = 0; i < kJoints; ++i) middle[i] = (limits.q_min[i] + limits.q_max[i]) / 2;
  return middle;
}

ChainBench::ChainBench(double lambda, double q_d)
    : ChainBench(loop::TickConfig{.lambda = lambda, .limiter = {}, .cost = {}}, {q_d}) {}

ChainBench::ChainBench(const loop::TickConfig& config, const JointVector& q_d)
    : chain_(config, control::CommandInterface::kJointPosition),
      rest_(q_d),
      reference_(onboard::JointReference::Rest(q_d)) {
  state_.q_d = reference_.q_d;
  chain_.Reset(state_);
}

double ChainBench::LargestShare(const JointLimits& limits) const noexcept {
  return std::max({std::abs(dq_d()) / limits.dq_max[0], std::abs(ddq_d()) / limits.ddq_max[0],
                   std::abs(jerk()) / limits.dddq_max[0]});
}

void ChainBench::Answer(double q_ext, double dq_ext, bool fresh, bool is_lost) noexcept {
  now_ += kCycle;
  if (fresh) source_time_ = now_;
  reference::Target target;
  target.joint.q = rest_;
  target.joint.q[0] = q_ext;
  target.joint.dq[0] = dq_ext;
  RobotCommand command;
  chain_.Next(state_, target, fresh, 1, source_time_, command);
  reference_ = is_lost ? reference_.AfterLoss() : reference_.AfterPosition(command.q_c);
  ++state_.message_id;
  state_.q_d = reference_.q_d;
  state_.dq_d = reference_.dq_d;
  state_.ddq_d = reference_.ddq_d;
}

}  // namespace twin::experiment

#include "experiment/chain_bench.h"

namespace twin::experiment {
namespace {

loop::TickConfig Config(double lambda) {
  loop::TickConfig config;
  config.lambda = lambda;
  return config;
}

}  // namespace

ChainBench::ChainBench(double lambda, double q_d)
    : chain_(Config(lambda), control::CommandInterface::kJointPosition),
      reference_(onboard::JointReference::Rest({q_d})) {
  state_.q_d = reference_.q_d;
  chain_.Reset(state_);
}

void ChainBench::Step(double q_ext, double dq_ext, bool fresh) noexcept {
  now_ += kCycle;
  if (fresh) source_time_ = now_;
  reference::Target target;
  target.joint.q[0] = q_ext;
  target.joint.dq[0] = dq_ext;
  RobotCommand command;
  chain_.Next(state_, target, fresh, 1, source_time_, command);
  reference_ = reference_.AfterPosition(command.q_c);
  ++state_.message_id;
  state_.q_d = reference_.q_d;
  state_.dq_d = reference_.dq_d;
  state_.ddq_d = reference_.ddq_d;
}

}  // namespace twin::experiment

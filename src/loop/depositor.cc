#include "twin/loop/depositor.h"

namespace twin::loop {

Depositor::Depositor(const ControllerLoopConfig& config, control::CommandInterface interface,
                     Exchange& exchange, std::uint64_t seed)
    : interface_(interface),
      exchange_(exchange),
      joint_(config.feed_forward, FromSeconds(1.0 / config.rate_hz)),
      pose_(config.feed_forward, FromSeconds(1.0 / config.rate_hz)),
      noise_(config.target_noise),
      random_(seed, RandomStream::kTargetNoise) {}

void Depositor::Reset() noexcept {
  joint_.Reset();
  pose_.Reset();
}

void Depositor::Put(const control::ControllerOutput& output, Time source_time,
                    std::uint64_t based_on) noexcept {
  if (!output.fresh && !output.finished && !output.failed) return;
  source_time = output.sampled_at.value_or(source_time);
  deposit_.target = output.target;
  deposit_.source_time = source_time;
  deposit_.based_on = based_on;
  deposit_.finished = output.finished;
  deposit_.failed = output.failed;
  if (noise_ > 0) AddNoise();
  if (!output.has_velocity && interface_ == control::CommandInterface::kJointPosition) {
    deposit_.target.joint.dq = joint_.Next(source_time, deposit_.target.joint.q).dq;
  }
  if (!output.has_velocity && interface_ == control::CommandInterface::kCartesianPose) {
    deposit_.target.pose.O_dP_EE = pose_.Next(source_time, deposit_.target.pose.O_T_EE).O_dP_EE;
  }
  exchange_.deposits.Publish(deposit_);
  ++count_;
}

void Depositor::AddNoise() noexcept {
  const auto disturb = [this](double& value, std::uint32_t axis) {
    value += noise_ * (2 * random_.Uniform(count_, axis) - 1);
  };
  reference::Target& target = deposit_.target;
  if (interface_ == control::CommandInterface::kCartesianPose) {
    for (std::uint32_t axis = 0; axis < 3; ++axis) disturb(target.pose.O_T_EE[12 + axis], axis);
    return;
  }
  JointVector& values = interface_ == control::CommandInterface::kTorque          ? target.tau_J_d
                        : interface_ == control::CommandInterface::kJointVelocity ? target.joint.dq
                                                                                  : target.joint.q;
  for (std::uint32_t j = 0; j < kJoints; ++j) disturb(values[j], j);
}

}  // namespace twin::loop

#include "run/stepped_chain.h"

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/loop/command_chain.h"
#include "twin/model/transform.h"

namespace twin::run {

SteppedChain::SteppedChain(rt::EventQueue& events, robot::Robot& robot,
                           control::CommandInterface interface, const loop::TickConfig& tick,
                           const loop::ControllerLoopConfig& controller)
    : events_(events), robot_(robot), interface_(interface), tick_(tick), controller_(controller) {
  tick_.Validate(interface_);
  controller_.Validate();
}

void SteppedChain::Start(const MotionModes& modes, std::uint64_t seed) {
  Stop();
  motion_ = std::make_unique<Motion>(*this, seed);
  motion_->tick.Activate(modes);
  holds_ = false;
  deposits_ = arrived_ = 0;
}

void SteppedChain::Stop() noexcept {
  ++serial_;
  computing_ = false;
  motion_.reset();
}

void SteppedChain::SetTarget(const reference::Target& target) {
  RobotCommand command;
  command.q_c = target.joint.q;
  command.dq_c = target.joint.dq;
  command.O_T_EE_c = target.pose.O_T_EE;
  command.tau_J_d = target.tau_J_d;
  if (!loop::IsValid(command, interface_)) {
    throw InputError(
        "target: it must be finite, and the rotation of a pose orthonormal within 1e-5");
  }
  output_.target = target;
}

reference::Target SteppedChain::Between(double share) const noexcept {
  if (share == 1) return output_.target;
  reference::Target target = output_.target;
  if (interface_ == control::CommandInterface::kJointPosition) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      target.joint.q[i] = from_.joint.q[i] + share * (target.joint.q[i] - from_.joint.q[i]);
    }
  } else if (interface_ == control::CommandInterface::kCartesianPose) {
    const Transform& from = from_.pose.O_T_EE;
    const Transform& to = output_.target.pose.O_T_EE;
    target.pose.O_T_EE =
        model::Pose(model::Orientation(from).slerp(share, model::Orientation(to)),
                    model::Position(from) + share * (model::Position(to) - model::Position(from)));
  }
  return target;
}

void SteppedChain::Deposit(Time wake, double share) noexcept {
  if (motion_ == nullptr || deposits_ - arrived_ == kMostOnTheWay) return;
  const Time source_time = wake + controller_.wake_delay.Draw(motion_->wake, deposits_);
  const std::uint64_t slot = deposits_ % kMostOnTheWay;
  on_the_way_[slot] = {output_, source_time, state_.message_id};
  on_the_way_[slot].output.target = Between(share);
  const Time done = source_time + controller_.cost.Draw(motion_->cost, deposits_);
  events_.Schedule(done, rt::EventOrder::kControllerDone, deposit_, serial_ * kMostOnTheWay + slot);
  ++deposits_;
}

void SteppedChain::Arrive(std::uint64_t slot) noexcept {
  const OnTheWay& deposit = on_the_way_[slot];
  motion_->depositor.Put(deposit.output, deposit.source_time, deposit.based_on);
  ++arrived_;
}

void SteppedChain::OnState(Time now) noexcept {
  if (computing_) return;  // it blocks on fresh states
  state_ = robot_.states().Take();
  if (motion_ == nullptr) return;
  command_ = motion_->tick.Tick(state_, now);
  if (!holds_ && motion_->tick.InMotion(state_)) Hold();
  const record::TickRecord& record = motion_->tick.record();
  if (record.margin) margin_ = std::min(*record.margin, margin_.value_or(*record.margin));
  kept_back_ += record.kept_back != 0 ? 1 : 0;
  computing_ = true;
  const Duration cost = tick_.cost.Draw(motion_->tick_cost, state_.message_id);
  events_.Schedule(now + cost, rt::EventOrder::kTickDone, done_, serial_ * kMostOnTheWay);
}

void SteppedChain::Write(std::uint64_t /*slot*/) noexcept {
  computing_ = false;
  if (command_ != nullptr) robot_.Send(*command_);
}

void SteppedChain::Hold() noexcept {
  holds_ = true;
  output_ = control::ControllerOutput();
  output_.target.joint.q = state_.q_d;
  output_.target.pose.O_T_EE = state_.O_T_EE_d;
  EndStep();
  // As if held for a period: the first step's way is that of a whole period.
  const Time held_since = events_.Now() - FromSeconds(1 / controller_.rate_hz);
  motion_->depositor.Put(output_, held_since, state_.message_id);
}

}  // namespace twin::run

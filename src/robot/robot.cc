#include "twin/robot/robot.h"

#include <utility>

namespace twin::robot {
namespace {

RobotConfig Validated(const RobotConfig& config) {
  config.Validate();
  return config;
}

}  // namespace

Robot::Robot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant, rt::EventQueue& events,
             rt::EventHandler& state_ready, rt::RecordSink* sink)
    : plant_(std::move(plant)),
      int_(Validated(config).onboard, config.q_start),
      events_(events),
      sink_(sink),
      states_(config.link, config.seed, events, state_ready),
      commands_(config.link, config.seed, events, inbox_),
      d_INT_(config.link.d_INT) {
  plant_->Reset(config.q_start);
  events_.Schedule(events_.Now() + kCycle, rt::EventOrder::kIntCycle, *this);
}

onboard::MoveStatus Robot::Move(const MotionModes& modes) noexcept {
  last_violations_ = onboard::Violations();
  return int_.Move(modes);
}

void Robot::Send(const RobotCommand& command) noexcept {
  commands_.Send(command);
}

void Robot::OnEvent(Time now, std::uint64_t /*token*/) noexcept {
  events_.Schedule(now + kCycle, rt::EventOrder::kIntCycle, *this);
  const RobotCommand* command = inbox_.Select(int_.message_id(), now - d_INT_);
  plant_->Step(int_.Cycle(command, plant_->sensors()));
  int_.FillState(plant_->sensors(), record_.state);
  states_.Send(record_.state);

  record_.violated = !int_.violations().empty();
  if (record_.violated) {
    last_violations_ = int_.violations();
    record_.violation = last_violations_.items().front();
  }
  if (sink_ == nullptr) return;
  record_.at = now;
  record_.dddq_d = int_.reference().dddq_d;
  record_.fate = int_.fate();
  record_.lost_in_row = int_.lost_in_row();
  record_.dropped = inbox_.dropped();
  sink_->Put(record_);
}

}  // namespace twin::robot

#include "twin/robot/robot.h"

#include <cmath>
#include <utility>

#include "twin/core/rest.h"

namespace twin::robot {
namespace {

RobotConfig Validated(const RobotConfig& config) {
  config.Validate();
  return config;
}

}  // namespace

Robot::Robot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant, rt::EventQueue& events,
             rt::EventHandler& state_ready, record::RecordSink* sink)
    : plant_(std::move(plant)),
      onboard_(Validated(config).onboard, config.q_start),
      events_(events),
      sink_(sink),
      states_(config.link, config.seed, events, state_ready),
      commands_(config.link, config.seed, events, inbox_),
      d_INT_(config.link.d_INT),
      clock_speed_(1 + config.clock_ppm * 1e-6),
      panel_(config.panel) {
  if (config.viability) {
    keeper_.emplace(config.onboard.limits, config.onboard.cartesian, *config.viability);
  }
  plant_->Reset(config.q_start);
  if (plant_->hand() != nullptr) hand_.emplace(*plant_->hand());
  if (plant_->base() != nullptr) base_.emplace(*plant_->base(), config.base);
}

void Robot::Begin() noexcept {
  begin_ = events_.Now();
  periods_ = 1;
  next_cycle_ = Due(periods_);
  ScheduleCycle();
}

Time Robot::Due(std::uint64_t periods) const noexcept {
  // Whole nanoseconds are exact in a double for 104 days, so without drift nothing is rounded.
  const auto own = static_cast<double>(periods * static_cast<std::uint64_t>(kCycle.count()));
  return begin_ + Duration(std::llround(own / clock_speed_));
}

Duration Robot::period() const noexcept {
  return Due(periods_ + 1) - next_cycle_;
}

void Robot::Postpone(Duration by) noexcept {
  begin_ += by;
  next_cycle_ = Due(periods_);
}

void Robot::ScheduleCycle() noexcept {
  events_.Schedule(next_cycle_, rt::EventOrder::kOnboardCycle, *this);
}

MoveStatus Robot::Move(const MotionModes& modes) noexcept {
  last_violations_ = onboard::Violations();
  return onboard_.Move(modes);
}

void Robot::Send(const RobotCommand& command) noexcept {
  commands_.Send(command);
}

bool Robot::AtRest() const noexcept {
  const JointVector& dq = record_.state.dq;
  return onboard_.reference().AtRest() && std::abs(dq[FastestJoint(dq)]) < kRestSpeed;
}

void Robot::OnEvent(Time now, std::uint64_t /*token*/) noexcept {
  const bool postponed = now < next_cycle_;
  if (!postponed) {
    next_cycle_ = Due(++periods_);
    Cycle(now);
  }
  ScheduleCycle();
}

void Robot::OperatePanel() noexcept {
  const Duration now = onboard_.message_id() * kCycle;
  while (next_panel_event_ < panel_.size() && panel_[next_panel_event_].at <= now) {
    // The robot may refuse a button; then it has no effect.
    static_cast<void>(onboard_.Operate(panel_[next_panel_event_].action));
    ++next_panel_event_;
  }
}

void Robot::Cycle(Time now) noexcept {
  OperatePanel();
  const bool in_motion = onboard_.robot_mode() == RobotMode::kMove;
  const RobotCommand* command = inbox_.Select(onboard_.message_id(), now - d_INT_);
  RobotCommand kept;
  const bool begun_before = onboard_.fate() != record::CommandFate::kNone;
  if (keeper_ && command != nullptr && begun_before) {
    kept = keeper_->Keep(record_.state, *command);
    command = &kept;
  }
  if (hand_) hand_->Cycle();
  if (base_) base_->Cycle();
  const std::uint64_t begun = onboard_.motions_begun();
  const JointDrive& drive = onboard_.Cycle(command, plant_->sensors());
  if (onboard_.motions_begun() != begun) plant_->BeginMotion();
  plant_->Step(drive);
  onboard_.FillState(plant_->sensors(), record_.state);
  states_.Send(record_.state);

  record_.violated = !onboard_.violations().empty();
  if (record_.violated) {
    record_.violation = onboard_.violations().items().front();
    last_found_ = onboard_.violations();
    if (in_motion) last_violations_ = onboard_.violations();  // not those of a collision while idle
  }
  if (sink_ == nullptr) return;
  record_.at = now;
  if (base_) record_.base = base_->state();
  record_.dddq_d = onboard_.reference().dddq_d;
  record_.fate = onboard_.fate();
  record_.lost_in_row = onboard_.lost_in_row();
  record_.dropped = inbox_.dropped();
  sink_->Put(record_);
}

}  // namespace twin::robot

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
    : config_(Validated(config)),
      plant_(std::move(plant)),
      events_(events),
      sink_(sink),
      d_INT_(config.link.d_INT),
      clock_speed_(1 + config.clock_ppm * 1e-6),
      live_{.onboard = onboard::OnboardController(config.onboard, config.q_start),
            .states = StateLink(config.link, config.seed, events, state_ready),
            .commands = CommandLink(config.link, config.seed, events, live_.inbox)} {
  ResetBodies(config.q_start);
}

void Robot::ResetBodies(const JointVector& q) {
  if (config_.viability) {
    keeper_.emplace(config_.onboard.limits, config_.onboard.cartesian, *config_.viability);
  }
  plant_->Reset(q);
  if (plant_->hand() != nullptr) live_.hand.emplace(*plant_->hand());
  if (plant_->suction() != nullptr) live_.hand.emplace(*plant_->suction());
  if (plant_->base() != nullptr) base_.emplace(*plant_->base(), config_.base);
}

void Robot::Reset(const JointVector& q) {
  ResetBodies(q);
  live_.onboard.Restart(config_.onboard, q);
  live_.last_violations = onboard::Violations();
  live_.last_found = onboard::Violations();
}

void Robot::Renew(const LinkConfig& link, std::uint64_t seed) {
  link.Validate();
  live_.states.Renew(link, seed);
  live_.commands.Renew(link, seed);
  plant_->Reseed(seed);
}

Robot::Snapshot Robot::Save() noexcept {
  return {live_, plant_->Save(), base_ ? std::optional(base_->Save()) : std::nullopt};
}

void Robot::Restore(const Snapshot& snapshot) noexcept {
  const Time recorded = live_.record.at;
  live_ = snapshot.live_;
  live_.last_found = onboard::Violations();  // told before
  live_.ahead += recorded - live_.record.at;
  live_.record.at = recorded;
  plant_->Restore(*snapshot.plant_);
  if (base_) base_->Restore(*snapshot.base_);
}

RobotState Robot::Peek() const noexcept {
  if (live_.onboard.message_id() != 0) return live_.record.state;
  RobotState state;
  onboard::OnboardController unasked = live_.onboard;  // its filters shall not count this state
  unasked.FillState(plant_->sensors(), state);
  state.message_id = 0;
  return state;
}

void Robot::StandBy() noexcept {
  sink_ = nullptr;
  plant_->StandBy();
}

void Robot::Begin() noexcept {
  live_.begin = events_.Now();
  live_.periods = 1;
  live_.next_cycle = Due(live_.periods);
  ScheduleCycle();
}

Time Robot::Due(std::uint64_t periods) const noexcept {
  // Whole nanoseconds are exact in a double for 104 days, so without drift nothing is rounded.
  const auto own = static_cast<double>(periods * static_cast<std::uint64_t>(kCycle.count()));
  return live_.begin + Duration(std::llround(own / clock_speed_));
}

Duration Robot::period() const noexcept {
  return Due(live_.periods + 1) - live_.next_cycle;
}

void Robot::Postpone(Duration by) noexcept {
  live_.begin += by;
  live_.next_cycle = Due(live_.periods);
}

void Robot::ScheduleCycle() noexcept {
  events_.Schedule(live_.next_cycle, rt::EventOrder::kOnboardCycle, *this);
}

MoveStatus Robot::Move(const MotionModes& modes) noexcept {
  live_.last_violations = onboard::Violations();
  return live_.onboard.Move(modes);
}

void Robot::Send(const RobotCommand& command) noexcept {
  live_.commands.Send(command);
}

bool Robot::AtRest() const noexcept {
  const JointVector& dq = live_.record.state.dq;
  return live_.onboard.reference().AtRest() && std::abs(dq[FastestJoint(dq)]) < kRestSpeed;
}

void Robot::OnEvent(Time now, std::uint64_t /*token*/) noexcept {
  const bool postponed = now < live_.next_cycle;
  if (!postponed) {
    live_.next_cycle = Due(++live_.periods);
    Cycle(now);
  }
  ScheduleCycle();
}

void Robot::OperatePanel() noexcept {
  const Duration now = live_.onboard.message_id() * kCycle;
  while (live_.next_panel_event < config_.panel.size() &&
         config_.panel[live_.next_panel_event].at <= now) {
    // The robot may refuse a button; then it has no effect.
    static_cast<void>(live_.onboard.Operate(config_.panel[live_.next_panel_event].action));
    ++live_.next_panel_event;
  }
}

void Robot::Cycle(Time now) noexcept {
  OperatePanel();
  const bool in_motion = live_.onboard.robot_mode() == RobotMode::kMove;
  const RobotCommand* command =
      live_.inbox.Select(live_.onboard.oldest_answered(), live_.onboard.message_id(), now - d_INT_);
  RobotCommand kept;
  const bool begun_before = live_.onboard.fate() != record::CommandFate::kNone;
  if (keeper_ && command != nullptr && begun_before && !is_asynchronous()) {
    kept = keeper_->Keep(live_.record.state, *command);
    command = &kept;
  }
  if (live_.hand) live_.hand->Cycle();
  if (base_) base_->Cycle();
  const std::uint64_t begun = live_.onboard.motions_begun();
  const JointDrive& drive = live_.onboard.Cycle(command, plant_->sensors());
  if (live_.onboard.motions_begun() != begun) plant_->BeginMotion();
  plant_->Step(drive);
  live_.onboard.FillState(plant_->sensors(), live_.record.state);
  live_.states.Send(live_.record.state);

  live_.record.violated = !live_.onboard.violations().empty();
  if (live_.record.violated) {
    live_.record.violation = live_.onboard.violations().items().front();
    live_.last_found = live_.onboard.violations();
    if (in_motion)
      live_.last_violations = live_.onboard.violations();  // not those of a collision while idle
  }
  live_.record.at = now + live_.ahead;
  if (sink_ == nullptr) return;
  if (base_) live_.record.base = base_->state();
  live_.record.dddq_d = live_.onboard.reference().dddq_d;
  live_.record.fate = live_.onboard.fate();
  live_.record.lost_in_row = live_.onboard.lost_in_row();
  live_.record.dropped = live_.inbox.dropped();
  sink_->Put(live_.record);
}

}  // namespace twin::robot

#include "twin/loop/state_time_loop.h"

namespace twin::loop {
namespace {

/// Of the robot's time between two states.
Duration Between(std::uint64_t first_id, std::uint64_t id) noexcept {
  return kCycle * static_cast<std::int64_t>(id - first_id);
}

}  // namespace

Time StateTimeLoop::ReadAt(const RobotState& state, Time /*arrival*/) noexcept {
  if (first_id_ == 0) first_id_ = state.message_id;
  now_ = Time(Between(first_id_, state.message_id));
  return now_;
}

const RobotCommand* StateTimeLoop::Compute(const RobotState& state, Time read,
                                           Duration& cost) noexcept {
  cost = Duration::zero();
  tick_.Publish(state, read);
  if (tick_.InMotion(state) && !stopped_) Control(state);
  return tick_.Answer(state);
}

void StateTimeLoop::Control(const RobotState& state) noexcept {
  if (!moving_) {
    moving_ = true;
    motion_id_ = state.message_id;
    wake_ = controller_.Start(Time());
  }
  const Time now(Between(motion_id_, state.message_id));
  // After lost states: the wake-up that is due, and then, the others skipped, one that is due now.
  while (wake_ <= now) {
    wake_ = controller_.OnWake(wake_) ? controller_.OnDone(now) : controller_.NextWake(now);
  }
}

}  // namespace twin::loop

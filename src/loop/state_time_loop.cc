#include "twin/loop/state_time_loop.h"

#include <chrono>

namespace twin::loop {
namespace {

/// Longest time between two states for which the controller's wake-ups are made up for; bounds the
/// work of a cycle.
constexpr Duration kLongestGap = std::chrono::milliseconds(64);

/// Robot time between two states.
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
  const bool controls = tick_.InMotion(state) && !stopped_;
  if (controls && moving_) WakeUntil(TimeOf(state) - Duration(1));
  tick_.Publish(state, read);
  if (controls) {
    if (!moving_) Begin(state);
    WakeUntil(TimeOf(state));
  }
  return tick_.Answer(state);
}

void StateTimeLoop::Begin(const RobotState& state) noexcept {
  moving_ = true;
  motion_id_ = state.message_id;
  wake_ = controller_.Start(Time());
}

Time StateTimeLoop::TimeOf(const RobotState& state) const noexcept {
  return Time(Between(motion_id_, state.message_id));
}

void StateTimeLoop::WakeUntil(Time end) noexcept {
  if (end - wake_ > kLongestGap) wake_ = controller_.NextWake(end - kLongestGap);
  while (wake_ <= end) {
    wake_ = controller_.OnWake(wake_) ? controller_.OnDone(wake_) : controller_.NextWake(wake_);
  }
}

}  // namespace twin::loop

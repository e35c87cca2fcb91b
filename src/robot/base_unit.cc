#include "twin/robot/base_unit.h"

#include <algorithm>
#include <cmath>

namespace twin::robot {
namespace {

constexpr double kStill = 1e-3;  // of a wheel, rad/s

}  // namespace

void BaseUnit::Cycle() noexcept {
  asked_.store(false, std::memory_order_relaxed);
  Take();
  if (live_.stopped) live_.command.reset();
  body_.Drive(live_.controller.Cycle(body_.sensors(), live_.command, live_.stopped));
  live_.command.reset();
  shown_.Publish(live_.controller.state());
}

void BaseUnit::Take() noexcept {
  live_.stopped = stopped_.load(std::memory_order_relaxed);
  if (commands_.Refresh()) live_.command = commands_.value();
}

BaseUnit::State BaseUnit::Save() noexcept {
  Take();
  return live_;
}

void BaseUnit::Restore(const State& state) noexcept {
  Take();  // what was sent until now
  live_ = state;
  stopped_.store(state.stopped, std::memory_order_relaxed);
  asked_.store(state.command.has_value(), std::memory_order_relaxed);
  shown_.Publish(state.controller.state());
}

void BaseUnit::Drive(const BaseTwist& twist) noexcept {
  if (stopped_.load(std::memory_order_relaxed)) return;
  commands_.Publish(twist);
  asked_.store(true, std::memory_order_relaxed);
}

bool BaseUnit::AtRest() const noexcept {
  const BaseState& now = state();
  return !asked_.load(std::memory_order_relaxed) && now.mode != BaseMode::kDriving &&
         now.twist_d == BaseTwist() &&
         std::ranges::all_of(now.dq_wheels, [](double dq) { return std::abs(dq) < kStill; });
}

}  // namespace twin::robot

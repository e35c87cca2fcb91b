#include "twin/robot/base_unit.h"

#include <algorithm>
#include <cmath>

namespace twin::robot {
namespace {

constexpr double kStill = 1e-3;  // of a wheel, rad/s

}  // namespace

void BaseUnit::Cycle() noexcept {
  const bool stopped = stopped_.load(std::memory_order_relaxed);
  asked_.store(false, std::memory_order_relaxed);
  std::optional<BaseTwist> command;
  if (commands_.Refresh() && !stopped) command = commands_.value();
  body_.Drive(controller_.Cycle(body_.sensors(), command, stopped));
  shown_.Publish(controller_.state());
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

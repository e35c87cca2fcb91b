#include "twin/loop/wake_grid.h"

namespace twin::loop {

WakeGrid::WakeGrid(const ControllerLoopConfig& config, std::uint64_t seed) noexcept
    : rate_hz_(config.rate_hz),
      speed_(1 + config.clock_ppm * 1e-6),
      phase_(config.phase),
      delay_(config.wake_delay),
      random_(seed, RandomStream::kControllerWake) {}

Time WakeGrid::Start(Time now) noexcept {
  start_ = now;
  wake_ = 0;
  overruns_ = 0;
  return Due(0) + delay_.Draw(random_, 0);
}

Time WakeGrid::Due(std::uint64_t wake) const noexcept {
  return start_ + phase_ + FromSeconds(static_cast<double>(wake) / rate_hz_ / speed_);
}

Time WakeGrid::OwnTime(Time now) const noexcept {
  return Time(FromSeconds(ToSeconds(now.time_since_epoch()) * speed_));
}

Time WakeGrid::Next(Time now) noexcept {
  ++wake_;
  while (Due(wake_) < now) {
    ++wake_;
    ++overruns_;
  }
  return Due(wake_) + delay_.Draw(random_, wake_);
}

}  // namespace twin::loop

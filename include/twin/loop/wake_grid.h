#pragma once

#include <cstdint>

#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/loop/loop_config.h"

namespace twin::loop {

/// Wake-up times of a periodic loop of the workstation, on its own clock:
///   t_n = start + phase + (n / rate) / (1 + clock_ppm 1e-6) + wake delay.
/// After a computation that outlasts its period, the loop skips to the next instant of the grid and
/// counts an overrun; wake-ups are never made up for in a burst.
///
/// Threads: the loop's. Real-time: noexcept, allocates nothing.
class WakeGrid {
 public:
  /// @param config  validated. @param seed  lockstep: seed of the wake delays.
  WakeGrid(const ControllerLoopConfig& config, std::uint64_t seed) noexcept;

  /// The grid begins at `now` + phase. @returns the first wake-up.
  [[nodiscard]] Time Start(Time now) noexcept TWIN_REALTIME;
  /// @returns the next wake-up whose instant is not before `now`.
  [[nodiscard]] Time Next(Time now) noexcept TWIN_REALTIME;

  /// `now` on this loop's own clock.
  [[nodiscard]] Time OwnTime(Time now) const noexcept TWIN_REALTIME;
  /// Index of the next wake-up, from 0.
  [[nodiscard]] std::uint64_t wake() const noexcept { return wake_; }
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_; }

 private:
  [[nodiscard]] Time Due(std::uint64_t wake) const noexcept;

  double rate_hz_;
  double speed_;  ///< rate of this clock relative to the run's
  Duration phase_;
  faults::DelayModel delay_;
  Random random_;
  Time start_{};
  std::uint64_t wake_ = 0;
  std::uint64_t overruns_ = 0;
};

}  // namespace twin::loop

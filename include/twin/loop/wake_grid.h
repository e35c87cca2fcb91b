#pragma once

#include <cstdint>

#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/loop/loop_config.h"

namespace twin::loop {

/// The instants at which a periodic loop of the workstation wakes, on its own clock:
///   t_n = start + phase + (n / rate) / (1 + clock_ppm 1e-6), late by the wake delay.
/// A computation that outlasts its period skips to the next instant of the grid and is counted:
/// never a burst.
///
/// Threads: the loop's. Real-time: noexcept, allocates nothing.
class WakeGrid {
 public:
  /// @param config  validated. @param seed  lockstep: of the wake delays.
  WakeGrid(const ControllerLoopConfig& config, std::uint64_t seed) noexcept;

  /// The grid begins at `now` + phase. @returns the first wake-up.
  [[nodiscard]] Time Start(Time now) noexcept TWIN_REALTIME;
  /// @returns the next wake-up whose instant is not before `now`.
  [[nodiscard]] Time Next(Time now) noexcept TWIN_REALTIME;

  /// `now` as this loop's own clock shows it.
  [[nodiscard]] Time OwnTime(Time now) const noexcept TWIN_REALTIME;
  /// Number of the wake-up that is due, from 0.
  [[nodiscard]] std::uint64_t wake() const noexcept { return wake_; }
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_; }

 private:
  [[nodiscard]] Time Due(std::uint64_t wake) const noexcept;

  double rate_hz_;
  double speed_;  ///< of this clock
  Duration phase_;
  faults::DelayModel delay_;
  Random random_;
  Time start_{};
  std::uint64_t wake_ = 0;
  std::uint64_t overruns_ = 0;
};

}  // namespace twin::loop

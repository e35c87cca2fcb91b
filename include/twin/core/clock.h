#pragma once

#include <cstdint>

#include "twin/core/time.h"

namespace twin {

/// The only source of time: a virtual clock in lockstep, a monotonic one in realtime.
///
/// Threads: Now() from any thread. Real-time: Now() is noexcept and allocates nothing.
class Clock {
 public:
  virtual ~Clock() = default;
  /// @returns time since the start of the run.
  [[nodiscard]] virtual Time Now() const noexcept = 0;
};

/// The host's monotonic clock, counted from construction. For the realtime drive, progress displays
/// and the wall-clock figures in a run's side file; never for data in the log of a lockstep run.
class MonotonicClock final : public Clock {
 public:
  MonotonicClock();

  /// Restarts the clock at zero. Not while another thread reads it.
  void Restart() noexcept;

  [[nodiscard]] Time Now() const noexcept override;

  /// The same instant on CLOCK_MONOTONIC, ns, for absolute waits of the operating system.
  [[nodiscard]] std::int64_t MonotonicNs(Time at) const noexcept {
    return origin_ns_ + at.time_since_epoch().count();
  }

 private:
  std::int64_t origin_ns_;
};

}  // namespace twin

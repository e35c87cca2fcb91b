#pragma once

#include <cstdint>

#include "twin/core/time.h"

namespace twin {

/// The only way to read time. Lockstep gives a virtual clock, realtime a monotonic one.
///
/// Threads: Now() from any thread. Real-time: Now() is noexcept and allocates nothing.
class Clock {
 public:
  virtual ~Clock() = default;
  /// @returns time since the start of the run.
  [[nodiscard]] virtual Time Now() const noexcept = 0;
};

/// The host's monotonic clock, counted from construction. Used by the realtime drive, by progress
/// displays and for the wall-clock figures that go to a run's side file; never for anything that
/// ends in a log of a lockstep run.
class MonotonicClock final : public Clock {
 public:
  MonotonicClock();

  /// Starts the time line anew at zero. Not while another thread reads it.
  void Restart() noexcept;

  [[nodiscard]] Time Now() const noexcept override;

  /// The same instant on CLOCK_MONOTONIC, ns: what the operating system's absolute waits take.
  [[nodiscard]] std::int64_t MonotonicNs(Time at) const noexcept {
    return origin_ns_ + at.time_since_epoch().count();
  }

 private:
  std::int64_t origin_ns_;
};

}  // namespace twin

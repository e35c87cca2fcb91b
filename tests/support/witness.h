#pragma once

#include <cstdint>
#include <vector>

#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/rt/thread_setup.h"

namespace twin::test {

/// Cycles of 1 ms, counted from a common begin; both ends are part of it.
struct CycleRange {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// How late a host woke threads that do nothing but sleep, and what that may have cost a 1 kHz
/// loop.
struct Lateness {
  std::int64_t spoilt_in_row = 0;  ///< most cycles in a row
  std::int64_t spoilt_of_500 = 0;  ///< most cycles of any 500 in a row
  Duration most{};                 ///< of one wake-up
};

/// @param spoilt  in any order; they may overlap.
[[nodiscard]] Lateness CountSpoilt(const std::vector<CycleRange>& spoilt);

/// Witnesses what this host does to a run beside it: a thread on each processor wakes every
/// millisecond and notes how late it is.
///
/// A wake-up later than kTolerated spoils the cycles it missed and the one behind them: a state
/// that comes more than 250 us off its millisecond is not answered (TickConfig::period_tolerance),
/// it passes two wake-ups, the robot's and the client's, and the step to the next is as far off.
///
/// Its threads have the priority of the run's own, the least of them, so that what keeps those from
/// running keeps these.
class Witness {
 public:
  static constexpr Duration kTolerated = std::chrono::microseconds(125);

  /// Watches from here on. @param fifo_priority  0: the ordinary scheduler; that too where this
  /// user may not have it.
  explicit Witness(int fifo_priority);

  /// Stops watching. Once.
  [[nodiscard]] Lateness End();

 private:
  struct Watch {
    std::vector<CycleRange> spoilt;
    Duration most{};
  };

  const MonotonicClock clock_;
  std::vector<Watch> watches_;  // one for each processor
  std::vector<rt::StartedThread> threads_;
};

}  // namespace twin::test

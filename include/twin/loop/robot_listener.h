#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/core/clock.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/rt/duration_histogram.h"
#include "twin/rt/signal.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {

/// What was found by listening to a robot for a while.
struct ListenReport {
  std::uint64_t states = 0;          ///< that were read
  std::uint64_t lost = 0;            ///< that never were: gaps in their ids
  std::uint64_t in_time = 0;         ///< whose read was within the tolerance of 1 ms after the last
  double rate_hz = 0;                ///< of the robot's cycles, by this side's clock
  rt::DurationHistogram deviation;   ///< of the time between two reads from 1 ms, magnitude
  RobotState last;                   ///< the newest; message_id 0: none came
  std::vector<std::string> notices;  ///< what the thread was not permitted

  /// Share of the robot's cycles after the first state that a loop could have answered, in [0, 1].
  [[nodiscard]] double success_rate() const noexcept;
};

/// How long, and how.
struct ListenSettings {
  Duration span = std::chrono::milliseconds(500);       ///< from the first state on
  Duration tolerance = std::chrono::microseconds(500);  ///< of the time between two reads
  rt::ThreadSettings thread;  ///< of the thread that listens: as the motion's will be
};

/// A communication loop's dry run: reads states as it would, and sends nothing, so that nothing can
/// move the arm. What is queued at the beginning does not count.
///
/// Returns after the span, or when no state has come for 1 s.
///
/// Threads: the caller waits. @throws InputError when the thread's settings are none of this
/// machine's.
[[nodiscard]] ListenReport ListenToRobot(const MonotonicClock& clock, backend::Backend& backend,
                                         rt::Arrival& arrival, const ListenSettings& settings);

}  // namespace twin::loop

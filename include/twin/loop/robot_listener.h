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

/// State statistics of a robot, counted by the workstation.
struct ListenReport {
  std::uint64_t states = 0;          ///< states read
  std::uint64_t lost = 0;            ///< states missed: gaps in the message_ids
  std::uint64_t in_time = 0;         ///< states read 1 ms after the previous one, within tolerance
  double rate_hz = 0;                ///< robot cycles per second of this side's clock
  rt::DurationHistogram deviation;   ///< |time between two reads - 1 ms|
  RobotState last;                   ///< the newest state; message_id 0: none arrived
  std::vector<std::string> notices;  ///< thread settings that the system did not permit

  /// Share of the robot's cycles after the first state that a loop could have answered, in [0, 1].
  [[nodiscard]] double success_rate() const noexcept;
};

/// Duration and thread of ListenToRobot().
struct ListenSettings {
  Duration span = std::chrono::milliseconds(500);       ///< from the first state on
  Duration tolerance = std::chrono::microseconds(500);  ///< of the time between two reads
  rt::ThreadSettings thread;  ///< of the listening thread: the same as for a motion
};

/// Dry run of a communication loop: reads states as the loop does and sends nothing, so that the
/// arm cannot move. States that are queued at the beginning do not count.
///
/// Returns after the span, or when no state arrives for 1 s.
///
/// Threads: the caller waits. @throws InputError for thread settings that this machine does not
/// have.
[[nodiscard]] ListenReport ListenToRobot(const MonotonicClock& clock, backend::Backend& backend,
                                         rt::Arrival& arrival, const ListenSettings& settings);

}  // namespace twin::loop

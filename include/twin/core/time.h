#pragma once

#include <chrono>
#include <cstdint>

namespace twin {

/// Span of time, in whole nanoseconds.
using Duration = std::chrono::nanoseconds;

/// Clock tag of a run's time line, which starts at zero. The drive decides whether it is virtual
/// (lockstep) or the monotonic clock (realtime); nothing else may depend on that.
struct RunTimeline {
  using rep = Duration::rep;
  using period = Duration::period;
  using duration = Duration;
  using time_point = std::chrono::time_point<RunTimeline, Duration>;
  static constexpr bool is_steady = true;
};

/// An instant of the run.
using Time = RunTimeline::time_point;

/// The cycle of the robot's controller, T_delta = 1 ms (paper section 2; FCI protocol 5).
inline constexpr Duration kCycle = std::chrono::milliseconds(1);

/// The same cycle in seconds, for difference quotients.
inline constexpr double kCycleSeconds = 1e-3;
/// The same, by its symbol in formulas.
inline constexpr double kT = kCycleSeconds;

/// Seconds as a double, for arithmetic on quantities; never for keeping time.
constexpr double ToSeconds(Duration d) {
  return std::chrono::duration<double>(d).count();
}
constexpr double ToMicroseconds(Duration d) {
  return ToSeconds(d) * 1e6;
}

/// Nearest nanosecond to `seconds`, ties away from zero; larger values and NaN give a hundred
/// years, so that sums stay in range.
constexpr Duration FromSeconds(double seconds) {
  constexpr double kMost = 3.15e9;
  if (!(seconds < kMost)) return Duration(static_cast<std::int64_t>(kMost * 1e9));
  if (seconds < -kMost) return Duration(static_cast<std::int64_t>(-kMost * 1e9));
  return Duration(static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5)));
}

}  // namespace twin

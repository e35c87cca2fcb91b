#pragma once

#include <ctime>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"

namespace twin::rt {

/// Suspends the calling thread until `deadline` on `clock`, an absolute time, so that lateness does
/// not accumulate. Returns at once if it has passed.
void SleepUntil(const MonotonicClock& clock, Time deadline) noexcept TWIN_REALTIME;

/// Suspends the calling thread for about `duration` of host time. Only for helper threads off the
/// control path (the log's writer): nothing that a run must repeat may depend on it.
void Pause(Duration duration);

/// Largest age of a stamp. An older one predates a change of the wall clock, or belongs to no
/// current cycle.
inline constexpr Duration kOldestStamp = std::chrono::seconds(1);

/// Time of an event that the kernel stamped with its wall clock, such as a received packet:
///   at = now - clamp(wall clock now - stamp, 0, kOldestStamp),   now on `clock`.
/// So it is never later than now, whatever the wall clock does. If the thread is interrupted
/// between reading the two clocks, the result is too late by that time, never too early.
/// @param stamp  of CLOCK_REALTIME.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Time TimeOfKernelStamp(const MonotonicClock& clock,
                                     const timespec& stamp) noexcept TWIN_REALTIME;

/// `at` for absolute waits on CLOCK_MONOTONIC, limited to the range from the host's start to a
/// hundred years.
[[nodiscard]] timespec AbsoluteTime(const MonotonicClock& clock, Time at) noexcept;

}  // namespace twin::rt

#pragma once

#include <ctime>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"

namespace twin::rt {

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

}  // namespace twin::rt

#pragma once

#include <ctime>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"

namespace twin::rt {

/// The most that a stamp is taken to lie in the past. What waits longer was stamped by a wall clock
/// that has been set since, or belongs to no cycle any more.
inline constexpr Duration kOldestStamp = std::chrono::seconds(1);

/// When something happened that the kernel stamped with its wall clock, as it stamps received
/// packets:
///   at = now - clamp(wall clock now - stamp, 0, kOldestStamp),   now on `clock`.
/// So it is never later than now, whatever the wall clock does. A thread that is interrupted
/// between its looks at the two clocks gets an instant that is too late by as much, never one too
/// early.
/// @param stamp  of CLOCK_REALTIME.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
[[nodiscard]] Time TimeOfKernelStamp(const MonotonicClock& clock,
                                     const timespec& stamp) noexcept TWIN_REALTIME;

}  // namespace twin::rt

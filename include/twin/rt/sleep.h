#pragma once

#include "twin/core/clock.h"
#include "twin/core/realtime.h"

namespace twin::rt {

/// Suspends the calling thread until `deadline` on `clock`, an absolute time, so that lateness does
/// not accumulate. Returns at once if it has passed.
void SleepUntil(const MonotonicClock& clock, Time deadline) noexcept TWIN_REALTIME;

}  // namespace twin::rt

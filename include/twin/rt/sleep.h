#pragma once

#include "twin/core/clock.h"
#include "twin/core/realtime.h"

namespace twin::rt {

/// Lets the calling thread sleep until `deadline` of `clock`, an absolute instant: what one sleep
/// is late does not add to the next. Returns at once when it has passed.
void SleepUntil(const MonotonicClock& clock, Time deadline) noexcept TWIN_REALTIME;

}  // namespace twin::rt

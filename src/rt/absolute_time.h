#pragma once

#include <ctime>

#include "twin/core/clock.h"

namespace twin::rt {

/// `at` as the operating system's absolute waits on CLOCK_MONOTONIC take it; an instant before the
/// host's start becomes that start, one beyond a hundred years becomes those.
[[nodiscard]] timespec AbsoluteTime(const MonotonicClock& clock, Time at) noexcept;

}  // namespace twin::rt

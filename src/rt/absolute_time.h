#pragma once

#include <ctime>

#include "twin/core/clock.h"

namespace twin::rt {

/// `at` for absolute waits on CLOCK_MONOTONIC, limited to the range from the host's start to a
/// hundred years.
[[nodiscard]] timespec AbsoluteTime(const MonotonicClock& clock, Time at) noexcept;

}  // namespace twin::rt

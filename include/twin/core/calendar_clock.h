#pragma once

#include <string>

#include "twin/core/clock.h"

namespace twin {

/// The host's calendar: time since 1970-01-01, UTC. An administrator may set it back. For dates of
/// records; never for what a run does or logs.
class CalendarClock final : public Clock {
 public:
  [[nodiscard]] Time Now() const noexcept override;
};

/// @param at  of a CalendarClock. @returns "2026-11-23T22:50:45Z".
[[nodiscard]] std::string FormatUtc(Time at);

}  // namespace twin

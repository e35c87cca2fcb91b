#include "twin/core/clock.h"

#include <chrono>
#include <ctime>

#include <fmt/chrono.h>

#include "twin/core/calendar_clock.h"

namespace twin {
namespace {

std::int64_t MonotonicNanoseconds() noexcept {
  return std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

MonotonicClock::MonotonicClock() : origin_ns_(MonotonicNanoseconds()) {}

void MonotonicClock::Restart() noexcept {
  origin_ns_ = MonotonicNanoseconds();
}

Time MonotonicClock::Now() const noexcept {
  return Time(Duration(MonotonicNanoseconds() - origin_ns_));
}

Time CalendarClock::Now() const noexcept {
  return Time(
      std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch()));
}

std::string FormatUtc(Time at) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(at.time_since_epoch());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(static_cast<std::time_t>(seconds.count())));
}

}  // namespace twin

#include "rt/absolute_time.h"

#include <algorithm>
#include <cstdint>

namespace twin::rt {
namespace {

/// Long enough for any wait, and the sum with the clock's origin does not overflow.
constexpr Time kForever{std::chrono::hours(24 * 365 * 100)};

}  // namespace

timespec AbsoluteTime(const MonotonicClock& clock, Time at) noexcept {
  constexpr std::int64_t kSecond = 1'000'000'000;
  // The system rejects a negative time instead of treating it as past.
  const std::int64_t ns = std::max<std::int64_t>(0, clock.MonotonicNs(std::min(at, kForever)));
  timespec time{};
  time.tv_sec = ns / kSecond;
  time.tv_nsec = ns % kSecond;
  return time;
}

}  // namespace twin::rt

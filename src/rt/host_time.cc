#include "twin/rt/host_time.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <ctime>
#include <thread>

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

void SleepUntil(const MonotonicClock& clock, Time deadline) noexcept {
  const timespec until = AbsoluteTime(clock, deadline);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

void Pause(Duration duration) {
  std::this_thread::sleep_for(duration);
}

Time TimeOfKernelStamp(const MonotonicClock& clock, const timespec& stamp) noexcept {
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  const Time now = clock.Now();
  // Whole seconds first: nanoseconds between distant stamps would overflow.
  const auto seconds = std::clamp<std::time_t>(wall.tv_sec - stamp.tv_sec, -2, 2);
  const Duration age = std::chrono::seconds(seconds) + Duration(wall.tv_nsec - stamp.tv_nsec);
  return now - std::clamp(age, Duration::zero(), kOldestStamp);
}

}  // namespace twin::rt

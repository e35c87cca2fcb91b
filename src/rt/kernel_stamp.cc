#include "twin/rt/kernel_stamp.h"

#include <algorithm>

namespace twin::rt {

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

#include "twin/rt/sleep.h"

#include <cerrno>
#include <ctime>

#include "rt/absolute_time.h"

namespace twin::rt {

void SleepUntil(const MonotonicClock& clock, Time deadline) noexcept {
  const timespec until = AbsoluteTime(clock, deadline);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace twin::rt

#include "twin/core/clock.h"

#include <chrono>

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

}  // namespace twin

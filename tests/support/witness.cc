#include "support/witness.h"

#include <sched.h>

#include <algorithm>
#include <stop_token>

#include "twin/rt/host_time.h"

namespace twin::test {
namespace {

/// Those this process may run on.
std::vector<int> Processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> processors;
  if (sched_getaffinity(0, sizeof set, &set) != 0) return {0};
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set)) processors.push_back(cpu);
  }
  return processors;
}

}  // namespace

Lateness CountSpoilt(const std::vector<CycleRange>& spoilt) {
  constexpr std::size_t kWindow = 500;
  std::vector<bool> is_spoilt;
  for (const CycleRange& range : spoilt) {
    const auto end = static_cast<std::size_t>(range.last) + 1;
    if (is_spoilt.size() < end) is_spoilt.resize(end);
    std::fill(is_spoilt.begin() + range.first, is_spoilt.begin() + range.last + 1, true);
  }
  Lateness lateness;
  std::int64_t in_row = 0;
  std::int64_t in_window = 0;
  for (std::size_t i = 0; i < is_spoilt.size(); ++i) {
    in_row = is_spoilt[i] ? in_row + 1 : 0;
    in_window += is_spoilt[i] ? 1 : 0;
    if (i >= kWindow && is_spoilt[i - kWindow]) --in_window;
    lateness.spoilt_in_row = std::max(lateness.spoilt_in_row, in_row);
    lateness.spoilt_of_500 = std::max(lateness.spoilt_of_500, in_window);
  }
  return lateness;
}

Witness::Witness(int fifo_priority) {
  const std::vector<int> processors = Processors();
  watches_.resize(processors.size());
  const Time begin = clock_.Now();
  for (std::size_t i = 0; i < processors.size(); ++i) {
    rt::ThreadSettings settings;
    settings.name = "witness";
    settings.fifo_priority = fifo_priority;
    settings.cpu = processors[i];
    settings.lock_memory = false;
    const auto watch = [this, begin, i](const std::stop_token& stop) {
      Watch& mine = watches_[i];
      std::int64_t cycle = (clock_.Now() - begin) / kCycle + 1;
      while (!stop.stop_requested()) {
        const Time due = begin + cycle * kCycle;
        rt::SleepUntil(clock_, due);
        const Duration late = clock_.Now() - due;
        mine.most = std::max(mine.most, late);
        const std::int64_t next = cycle + late / kCycle + 1;
        if (late > kTolerated) mine.spoilt.push_back({cycle, next});
        cycle = next;
      }
    };
    threads_.push_back(rt::StartThread(settings, watch));
  }
}

Lateness Witness::End() {
  for (rt::StartedThread& one : threads_) one.thread.request_stop();
  threads_.clear();
  std::vector<CycleRange> spoilt;
  for (const Watch& watch : watches_) {
    spoilt.insert(spoilt.end(), watch.spoilt.begin(), watch.spoilt.end());
  }
  Lateness lateness = CountSpoilt(spoilt);
  lateness.most = std::ranges::max(watches_, {}, &Watch::most).most;
  return lateness;
}

}  // namespace twin::test

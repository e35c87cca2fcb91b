#include "support/witness.h"

#include <sched.h>

#include <algorithm>
#include <stop_token>

#include "twin/rt/sleep.h"

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

std::int64_t LongestRun(std::vector<CycleRange> ranges) {
  std::ranges::sort(ranges, {}, &CycleRange::first);
  std::int64_t longest = 0;
  CycleRange run{0, -2};
  for (const CycleRange& range : ranges) {
    if (range.first > run.last + 1) run = range;
    run.last = std::max(run.last, range.last);
    longest = std::max(longest, run.last - run.first + 1);
  }
  return longest;
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
  Lateness lateness;
  std::vector<CycleRange> spoilt;
  for (const Watch& watch : watches_) {
    spoilt.insert(spoilt.end(), watch.spoilt.begin(), watch.spoilt.end());
    lateness.most = std::max(lateness.most, watch.most);
  }
  lateness.spoilt_in_row = LongestRun(std::move(spoilt));
  return lateness;
}

}  // namespace twin::test

#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "twin/core/time.h"
#include "twin/rt/duration_histogram.h"

// How well a host keeps a 1 kHz loop, and what may make it better.
namespace twin::loop {

/// What a host is, as far as it bears on keeping time.
struct HostFacts {
  std::string processor = "unknown processor";  ///< its name
  unsigned processors = 1;                      ///< in use
  bool virtual_machine = false;
  std::string governor;          ///< of the first processor's frequency; empty: none
  std::string kernel;            ///< "Linux 6.1.0 x86_64"
  std::string kernel_release;    ///< "6.1.0"
  bool realtime_kernel = false;  ///< PREEMPT_RT
  double load = 0;               ///< mean number of runnable threads in the last minute
  bool may_use_fifo = false;     ///< SCHED_FIFO 99 is allowed
};

[[nodiscard]] HostFacts ReadHostFacts();

/// What may make 1 kHz loops keep time better here, the most effective first; one line each.
[[nodiscard]] std::vector<std::string> JitterCures(const HostFacts& facts);

/// An answer that takes longer counts as lost: what the robot's documentation recommends for d_EXT.
inline constexpr Duration kAnswerInTime = std::chrono::microseconds(500);

/// How well this host keeps a 1 kHz loop, with threads set up like those of a run in real time.
struct JitterFigures {
  rt::DurationHistogram wake_up;   ///< how late an absolute wake-up every 1 ms was
  rt::DurationHistogram answer;    ///< from a state's sending to the end of its answer's writing
  std::uint64_t cycles = 0;        ///< states sent, and those that could not be
  std::uint64_t unserved = 0;      ///< of them without an answer within kAnswerInTime
  std::uint64_t longest_loss = 0;  ///< most of those in a row
};

/// Measures for twice `duration`: first the wake-ups of one thread, then the answers that a
/// communication thread gives to a robot's thread. Both only sleep and wake; nothing spins. What
/// the threads are not permitted is left out. Locks the program's memory, where permitted.
[[nodiscard]] JitterFigures MeasureJitter(Duration duration);

/// What that means for a 1 kHz loop.
struct JitterVerdict {
  bool good = false;  ///< nothing is to be done
  std::string text;   ///< for people, one line
};
[[nodiscard]] JitterVerdict Evaluate(const JitterFigures& figures);

}  // namespace twin::loop

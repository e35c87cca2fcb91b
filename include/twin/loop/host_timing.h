#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "twin/core/time.h"
#include "twin/rt/duration_histogram.h"

// Timing of a 1 kHz loop on this host, and advice to improve it.
namespace twin::loop {

/// Properties of a host that affect its timing.
struct HostFacts {
  std::string processor = "unknown processor";  ///< its name
  unsigned processors = 1;                      ///< in use
  bool virtual_machine = false;
  std::string governor;          ///< frequency governor of the first processor; empty: none
  std::string kernel;            ///< "Linux 6.1.0 x86_64"
  std::string kernel_release;    ///< "6.1.0"
  bool realtime_kernel = false;  ///< PREEMPT_RT
  double load = 0;               ///< mean number of runnable threads in the last minute
  bool may_use_fifo = false;     ///< SCHED_FIFO 99 is permitted
};

[[nodiscard]] HostFacts ReadHostFacts();

/// Measures that may reduce the jitter of 1 kHz loops on this host, most effective first; one line
/// each.
[[nodiscard]] std::vector<std::string> JitterCures(const HostFacts& facts);

/// Longest answer that is not counted as lost: the robot documentation's recommendation for d_EXT.
inline constexpr Duration kAnswerInTime = std::chrono::microseconds(500);

/// Measured timing of a 1 kHz loop on this host, with threads set up as in a real-time run.
struct JitterFigures {
  rt::DurationHistogram wake_up;   ///< lateness of an absolute wake-up every 1 ms
  rt::DurationHistogram answer;    ///< from the send of a state to the end of its answer's write
  std::uint64_t cycles = 0;        ///< states sent, and states skipped because of a late wake-up
  std::uint64_t unserved = 0;      ///< cycles without an answer within kAnswerInTime
  std::uint64_t longest_loss = 0;  ///< most unserved cycles in a row
};

/// Measures for twice `duration`: first the wake-ups of one thread, then the answers of a
/// communication thread to a robot's thread. The threads sleep and wake; none spins. Thread
/// settings that the system does not permit are left out. Locks the process memory, if permitted.
[[nodiscard]] JitterFigures MeasureJitter(Duration duration);

/// Lateness of the wake-ups of an ordinary thread, without real-time priority, that computes for
/// 0.2 ms every 1 ms, as clients of a robot do. Measures for `duration`.
[[nodiscard]] rt::DurationHistogram MeasureOrdinaryWakeUps(Duration duration);

/// Assessment of the figures for a 1 kHz loop.
struct JitterVerdict {
  bool good = false;  ///< no action is needed
  std::string text;   ///< for users, one line
};
[[nodiscard]] JitterVerdict Evaluate(const JitterFigures& figures);
/// The same of ordinary threads: not good if one was ever so late that the robot would end the
/// motion, or in one of a hundred wake-ups by more than a cycle. For `text` as the other's.
[[nodiscard]] JitterVerdict EvaluateOrdinary(const rt::DurationHistogram& wake_ups);

}  // namespace twin::loop

#pragma once

#include <string>
#include <vector>

namespace twin::cli {

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

}  // namespace twin::cli

#include "cli/host_facts.h"

#include <sched.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <fstream>
#include <string_view>
#include <thread>

#include <fmt/format.h>

#include "cli/host.h"

namespace twin::cli {
namespace {

void ReadProcessor(HostFacts& facts) {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line) && !line.empty();) {  // the first one's
    const auto colon = line.find(": ");
    if (colon == std::string::npos) continue;
    if (line.starts_with("model name")) facts.processor = line.substr(colon + 2);
    if (line.starts_with("flags")) {
      facts.virtual_machine = (line + ' ').find(" hypervisor ") != std::string::npos;
    }
  }
  facts.processors = std::thread::hardware_concurrency();
  facts.governor = FirstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
}

void ReadKernel(HostFacts& facts) {
  utsname names{};
  uname(&names);
  facts.kernel = fmt::format("{} {} {}", names.sysname, names.release, names.machine);
  facts.kernel_release = names.release;
  facts.realtime_kernel = FirstLine("/sys/kernel/realtime") == "1" ||
                          std::string_view(names.version).find("PREEMPT_RT") != std::string::npos;
}

/// Tried on a thread of its own.
bool MayUseFifo() {
  bool allowed = false;
  std::thread([&allowed] {
    sched_param priority{};
    priority.sched_priority = sched_get_priority_max(SCHED_FIFO);
    allowed = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  }).join();
  return allowed;
}

}  // namespace

HostFacts ReadHostFacts() {
  HostFacts facts;
  ReadProcessor(facts);
  ReadKernel(facts);
  getloadavg(&facts.load, 1);
  facts.may_use_fifo = MayUseFifo();
  return facts;
}

std::vector<std::string> JitterCures(const HostFacts& facts) {
  std::vector<std::string> cures;
  if (!facts.may_use_fifo) {
    cures.emplace_back("allow SCHED_FIFO (above): it is what keeps other programs away");
  }
  if (facts.load > 0.5 * facts.processors) {
    cures.push_back(fmt::format(
        "stop other programs: in the last minute {:.1f} threads wanted the {} processors",
        facts.load, facts.processors));
  }
  if (!facts.governor.empty() && facts.governor != "performance") {
    cures.push_back(
        fmt::format("the processor's frequency follows its load (governor \"{}\"): cpupower "
                    "frequency-set -g performance",
                    facts.governor));
  }
  cures.emplace_back(
      "keep the processors out of deep sleep: hold /dev/cpu_dma_latency open with 0 written to it, "
      "or boot with processor.max_cstate=1");
  cures.emplace_back(
      "give the threads processors of their own: boot with isolcpus=N, then run with --ext-cpu and "
      "--int-cpu");
  if (!facts.realtime_kernel) {
    cures.emplace_back("a PREEMPT_RT kernel: apt-get install linux-image-rt-amd64");
  }
  if (facts.virtual_machine) {
    cures.emplace_back(
        "this is a virtual machine: when it runs is up to its host; a machine of its own keeps "
        "time "
        "better");
  }
  return cures;
}

}  // namespace twin::cli

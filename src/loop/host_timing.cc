#include "twin/loop/host_timing.h"

#include <sched.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <latch>
#include <stop_token>
#include <string_view>
#include <thread>

#include <fmt/format.h>

#include "twin/core/clock.h"
#include "twin/rt/host_time.h"
#include "twin/rt/latest_value.h"
#include "twin/rt/signal.h"
#include "twin/rt/thread_setup.h"

namespace twin::loop {
namespace {

/// First line of a file of /proc or /sys; empty when it cannot be read.
std::string FirstLine(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

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

/// Tries it on a separate thread.
bool MayUseFifo() {
  bool allowed = false;
  std::thread([&allowed] {
    sched_param priority{};
    priority.sched_priority = sched_get_priority_max(SCHED_FIFO);
    allowed = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  }).join();
  return allowed;
}

/// Bounds on the share of unserved cycles: the paper's stack works well at 0.4 %; libfranka's
/// communication_test warns above 5 %. After more than kEndsMotion in a row, the robot ends the
/// motion.
constexpr double kGoodShare = 0.005;
constexpr double kUsableShare = 0.05;
constexpr std::uint64_t kEndsMotion = 20;

/// Instants 1 ms apart; skips and counts those that have passed.
class Grid {
 public:
  explicit Grid(Time now) : due_(now + kCycle) {}
  [[nodiscard]] Time due() const noexcept { return due_; }
  /// @returns the number of skipped instants.
  std::uint64_t Advance(Time now) noexcept {
    due_ += kCycle;
    const auto passed = std::max<Duration::rep>(0, (now - due_) / kCycle);
    due_ += passed * kCycle;
    return static_cast<std::uint64_t>(passed);
  }

 private:
  Time due_;
};

void MakeUrgent(const char* name, int priority) {
  rt::ThreadSettings settings;
  settings.name = name;
  settings.fifo_priority = priority;
  static_cast<void>(rt::SetUpThisThread(settings));
}

/// The robot's thread sends numbered states to the communication thread, which answers.
class RoundTrips {
 public:
  RoundTrips(const MonotonicClock& clock, JitterFigures& figures)
      : clock_(clock), figures_(figures), arrived_(clock) {}

  /// Threads: the communication thread.
  void Answer(const std::stop_token& stop) noexcept {
    while (!stop.stop_requested()) {
      if (!arrived_.AwaitUntil(clock_.Now() + 50 * kCycle) || !states_.Refresh()) continue;
      const Message state = states_.value();
      const Duration took = clock_.Now() - state.sent;
      answers_.Publish({state.id, state.sent, took});
      figures_.answer.Add(took);
    }
  }

  /// Threads: the robot's.
  void Send(Time end) noexcept {
    Grid grid(clock_.Now());
    std::uint64_t skipped = 0;
    for (std::uint64_t id = 0;; skipped = grid.Advance(clock_.Now())) {
      rt::SleepUntil(clock_, grid.due());
      if (id > 0) Count(id);
      Lose(skipped);
      if (grid.due() > end) return;
      states_.Publish({++id, clock_.Now(), {}});
      arrived_.Notify();
    }
  }

 private:
  struct Message {
    std::uint64_t id = 0;
    Time sent{};
    Duration took{};
  };

  /// True if state `id` was answered in time.
  void Count(std::uint64_t id) noexcept {
    answers_.Refresh();
    const Message& answer = answers_.value();
    if (answer.id != id || answer.took > kAnswerInTime) {
      Lose(1);
      return;
    }
    ++figures_.cycles;
    lost_in_row_ = 0;
  }
  void Lose(std::uint64_t cycles) noexcept {
    figures_.cycles += cycles;
    figures_.unserved += cycles;
    lost_in_row_ += cycles;
    figures_.longest_loss = std::max(figures_.longest_loss, lost_in_row_);
  }

  const MonotonicClock& clock_;
  JitterFigures& figures_;
  rt::Signal arrived_;
  std::uint64_t lost_in_row_ = 0;
  rt::LatestValue<Message> states_;
  rt::LatestValue<Message> answers_;
};

void MeasureWakeUps(const MonotonicClock& clock, Duration duration, JitterFigures& figures) {
  std::jthread([&] {
    MakeUrgent("twin-ext", 99);
    const Time end = clock.Now() + duration;
    for (Grid grid(clock.Now()); grid.due() <= end; grid.Advance(clock.Now())) {
      rt::SleepUntil(clock, grid.due());
      figures.wake_up.Add(clock.Now() - grid.due());
    }
  }).join();
}

void MeasureAnswers(const MonotonicClock& clock, Duration duration, JitterFigures& figures) {
  RoundTrips trips(clock, figures);
  std::latch ready(1);
  std::jthread communication([&](const std::stop_token& stop) {
    MakeUrgent("twin-ext", 99);
    ready.count_down();
    trips.Answer(stop);
  });
  std::jthread([&] {
    MakeUrgent("twin-robot", 98);
    ready.wait();
    trips.Send(clock.Now() + duration);
  }).join();
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

JitterFigures MeasureJitter(Duration duration) {
  const MonotonicClock clock;
  JitterFigures figures;
  MeasureWakeUps(clock, duration, figures);
  MeasureAnswers(clock, duration, figures);
  return figures;
}

rt::DurationHistogram MeasureOrdinaryWakeUps(Duration duration) {
  constexpr Duration kComputes = std::chrono::microseconds(200);
  const MonotonicClock clock;
  rt::DurationHistogram late;
  std::jthread([&] {
    const Time end = clock.Now() + duration;
    for (Grid grid(clock.Now()); grid.due() <= end; grid.Advance(clock.Now())) {
      rt::SleepUntil(clock, grid.due());
      const Time awake = clock.Now();
      late.Add(awake - grid.due());
      while (clock.Now() < awake + kComputes) {
      }
    }
  }).join();
  return late;
}

JitterVerdict EvaluateOrdinary(const rt::DurationHistogram& wake_ups) {
  const Duration often = wake_ups.Percentile(0.99);
  const bool ends_motion = wake_ups.max() >= static_cast<Duration::rep>(kEndsMotion) * kCycle;
  return {often <= kCycle && !ends_motion,
          fmt::format("busy: a thread without real-time priority, as clients may be, woke up to "
                      "{:.0f} ms late",
                      ToSeconds(wake_ups.max()) * 1e3)};
}

JitterVerdict Evaluate(const JitterFigures& figures) {
  if (figures.unserved == 0) {
    return {true, fmt::format("good for real time: none of {} cycles was missed", figures.cycles)};
  }
  const double share = static_cast<double>(figures.unserved) / static_cast<double>(figures.cycles);
  const std::string missed = fmt::format(
      "about {:.0f} of 10 000 cycles would be missed ({} of {} were, at most {} in a row)",
      std::max(1.0, share * 10'000), figures.unserved, figures.cycles, figures.longest_loss);
  if (figures.longest_loss >= kEndsMotion || share > kUsableShare) {
    return {false, fmt::format("not fit: {}, and the robot ends a motion at {} in a row; use "
                               "lockstep, or cure it",
                               missed, kEndsMotion)};
  }
  if (share > kGoodShare) {
    return {false,
            fmt::format("usable: {}; a gentle motion behind the reference generator bears them",
                        missed)};
  }
  return {true,
          fmt::format(
              "good for real time: {}; a gentle motion behind the reference generator bears them",
              missed)};
}

}  // namespace twin::loop

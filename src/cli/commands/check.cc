#include <sys/resource.h>
#include <array>
#include <cstdio>
#include <string>

#include <GL/osmesa.h>
#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/shared_flags.h"
#include "twin/core/error.h"
#include "twin/loop/host_timing.h"

namespace twin::cli {
namespace {

struct CheckFlags {
  double seconds = 2;  ///< of each measurement, in [0.5, 60]
  DataFlags data;
};

/// How a finding bears on what the twin can do here.
enum class Verdict {
  kGood,
  kAdvice,   ///< works without it, but less well
  kMissing,  ///< something the twin promises does not work
};

/// Prints findings and remembers whether one of them is a failure.
class CheckFindings {
 public:
  void Add(Verdict verdict, std::string_view subject, const std::string& text) {
    constexpr std::array kMarks{"ok", "note", "FAIL"};
    Say(stdout,
        fmt::format("{:<5} {:<12} {}\n", kMarks[static_cast<std::size_t>(verdict)], subject, text));
    failed_ = failed_ || verdict == Verdict::kMissing;
  }
  [[nodiscard]] bool failed() const noexcept { return failed_; }

 private:
  bool failed_ = false;
};

void CheckComputer(CheckFindings& findings, const loop::HostFacts& facts) {
  findings.Add(Verdict::kGood, "processor",
               fmt::format("{}, {} in use{}", facts.processor, facts.processors,
                           facts.virtual_machine ? ", of a virtual machine" : ""));
  findings.Add(Verdict::kGood, "kernel",
               fmt::format("{}{}", facts.kernel,
                           facts.realtime_kernel ? ", PREEMPT_RT"
                                                 : ", not a real-time kernel (none is needed)"));
}

void CheckPermissions(CheckFindings& findings, const loop::HostFacts& facts) {
  if (facts.may_use_fifo) {
    findings.Add(Verdict::kGood, "scheduler", "SCHED_FIFO 99 is allowed");
  } else {
    findings.Add(Verdict::kAdvice, "scheduler",
                 "SCHED_FIFO is not allowed; lockstep needs none. For real time add \"@realtime - "
                 "rtprio 99\" to /etc/security/limits.conf and yourself to the group realtime");
  }
  rlimit memory{};
  getrlimit(RLIMIT_MEMLOCK, &memory);
  if (memory.rlim_cur == RLIM_INFINITY) {
    findings.Add(Verdict::kGood, "memory lock", "unlimited");
  } else {
    findings.Add(Verdict::kAdvice, "memory lock",
                 fmt::format("at most {} kB; lockstep needs none. For real time add \"@realtime - "
                             "memlock unlimited\" to /etc/security/limits.conf",
                             memory.rlim_cur / 1024));
  }
}

/// Percentiles of a measurement, as text.
std::string Spread(const rt::DurationHistogram& histogram) {
  return fmt::format("{:.0f} us p50, {:.0f} us p99, {:.0f} us p99.9, {:.0f} us at most",
                     ToMicroseconds(histogram.Percentile(0.5)),
                     ToMicroseconds(histogram.Percentile(0.99)),
                     ToMicroseconds(histogram.Percentile(0.999)), ToMicroseconds(histogram.max()));
}

/// Last, because it takes its time and locks the program's memory.
void CheckJitter(CheckFindings& findings, const loop::HostFacts& facts, double seconds) {
  std::fflush(stdout);  // what has been found so far can be read meanwhile
  const loop::JitterFigures figures = loop::MeasureJitter(FromSeconds(seconds));
  findings.Add(Verdict::kGood, "wake-ups",
               fmt::format("every 1 ms, late by {} ({} samples, kernel {})",
                           Spread(figures.wake_up), figures.wake_up.count(), facts.kernel_release));
  findings.Add(Verdict::kGood, "answers",
               fmt::format("at 1 kHz from thread to thread, after {} ({} samples, in time: {:.0f} "
                           "us)",
                           Spread(figures.answer), figures.answer.count(),
                           ToMicroseconds(loop::kAnswerInTime)));
  const loop::JitterVerdict verdict = loop::Evaluate(figures);
  findings.Add(verdict.good ? Verdict::kGood : Verdict::kAdvice, "1 kHz", verdict.text);
  if (verdict.good) return;
  for (const std::string& cure : loop::JitterCures(facts))
    findings.Add(Verdict::kAdvice, "cure", cure);
}

void CheckProgram(CheckFindings& findings, const Host& host, const char* name, const char* purpose,
                  const char* package) {
  const auto file = FindProgram(name, host.path);
  if (!file.empty()) {
    findings.Add(Verdict::kGood, name, file.string());
    return;
  }
  findings.Add(Verdict::kMissing, name,
               fmt::format("not installed; {} need it: apt-get install {}", purpose, package));
}

void CheckRenderer(CheckFindings& findings) {
  const OSMesaContext context = OSMesaCreateContext(OSMESA_RGBA, nullptr);
  if (context == nullptr) {
    findings.Add(Verdict::kMissing, "OSMesa",
                 "gives no context, so there are no pictures; apt-get install --reinstall "
                 "libosmesa6 libgl1-mesa-dri");
    return;
  }
  OSMesaDestroyContext(context);
  findings.Add(Verdict::kGood, "OSMesa", "draws without a graphics card");
}

void CheckData(CheckFindings& findings, const DataFlags& flags, const Host& host) {
  try {
    const auto data = DataOf(flags, host);
    findings.Add(Verdict::kGood, "models", data.models.string());
    if (!data.mesh_package.empty()) {
      findings.Add(Verdict::kGood, "meshes", data.mesh_package.string());
    } else {
      findings.Add(Verdict::kAdvice, "meshes",
                   "not found: the arm is drawn in primitive shapes; scripts/setup fetches them, "
                   "or name their folder with --meshes");
    }
  } catch (const Error& error) {
    findings.Add(Verdict::kMissing, "models", error.what());
  }
  if (host.cache.empty()) {
    findings.Add(Verdict::kAdvice, "cache",
                 "neither XDG_CACHE_HOME nor HOME is set: models are compiled at each start");
  } else {
    findings.Add(Verdict::kGood, "cache", host.cache.string());
  }
}

int RunChecks(const CheckFlags& flags, const Program& program) {
  RequireInRange("--seconds", flags.seconds, 0.5, 60);
  const loop::HostFacts facts = loop::ReadHostFacts();
  CheckFindings findings;
  CheckComputer(findings, facts);
  CheckPermissions(findings, facts);
  CheckProgram(findings, program.host, "ffmpeg", "videos", "ffmpeg");
  CheckProgram(findings, program.host, "gnuplot", "plots", "gnuplot-nox");
  CheckRenderer(findings);
  CheckData(findings, flags.data, program.host);
  CheckJitter(findings, facts, flags.seconds);
  FinishOutput();
  if (!findings.failed()) return kOk;
  throw RobotFault("this host lacks what is marked FAIL above");
}

}  // namespace

void AddCheck(CLI::App& app, Program& program) {
  const auto [check, flags] = AddCommand(
      app, program, "check", "Say what this host offers, and what is missing", &RunChecks);
  Add(check, "--seconds S", flags.seconds, "Length of each of the two measurements (0.5 to 60)")
      ->capture_default_str();
  AddData(check, flags.data);
}

}  // namespace twin::cli

#include <sched.h>
#include <sys/resource.h>
#include <sys/utsname.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include <GL/osmesa.h>
#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/host.h"
#include "cli/say.h"
#include "twin/core/error.h"
#include "twin/scenario/data_directory.h"

namespace twin::cli {
namespace {

/// How a finding bears on what the twin can do here.
enum class Verdict {
  kGood,
  kAdvice,   ///< works without it, but less well
  kMissing,  ///< something the twin promises does not work
};

/// Prints findings and remembers whether one of them is a failure.
class Findings {
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

std::string CpuName() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("model name")) continue;
    const auto colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

void CheckComputer(Findings& findings) {
  findings.Add(Verdict::kGood, "processor",
               fmt::format("{}, {} in use", CpuName(), std::thread::hardware_concurrency()));
  utsname names{};
  uname(&names);
  const bool realtime = FirstLine("/sys/kernel/realtime") == "1" ||
                        std::string_view(names.version).find("PREEMPT_RT") != std::string::npos;
  findings.Add(
      Verdict::kGood, "kernel",
      fmt::format("{} {} {}{}", names.sysname, names.release, names.machine,
                  realtime ? ", PREEMPT_RT" : ", not a real-time kernel (none is needed)"));
}

/// Whether this process may run at a real-time priority; tried on a thread of its own.
bool MayUseFifo() {
  bool allowed = false;
  std::thread([&allowed] {
    sched_param priority{};
    priority.sched_priority = sched_get_priority_max(SCHED_FIFO);
    allowed = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  }).join();
  return allowed;
}

void CheckRealtime(Findings& findings) {
  if (MayUseFifo()) {
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

void CheckProgram(Findings& findings, const Host& host, const char* name, const char* purpose,
                  const char* package) {
  const auto file = FindProgram(name, host.path);
  if (!file.empty()) {
    findings.Add(Verdict::kGood, name, file.string());
    return;
  }
  findings.Add(Verdict::kMissing, name,
               fmt::format("not installed; {} need it: apt-get install {}", purpose, package));
}

void CheckRenderer(Findings& findings) {
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

void CheckData(Findings& findings, const DataFlags& flags, const Host& host) {
  try {
    const auto data = scenario::FindDataDirectory({host.executable, flags.models, flags.meshes});
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

}  // namespace

ExitCode CheckCommand(const DataFlags& flags, const Host& host) {
  Findings findings;
  CheckComputer(findings);
  CheckRealtime(findings);
  CheckProgram(findings, host, "ffmpeg", "videos", "ffmpeg");
  CheckProgram(findings, host, "gnuplot", "plots", "gnuplot-nox");
  CheckRenderer(findings);
  CheckData(findings, flags, host);
  FinishOutput();
  if (!findings.failed()) return kOk;
  throw RobotFault("this host lacks what is marked FAIL above");
}

}  // namespace twin::cli

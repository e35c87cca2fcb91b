#include "cli/run_setup.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

#include "cli/host.h"
#include "cli/remote_run.h"
#include "cli/say.h"
#include "cli/summary.h"
#include "cli/wire_capture.h"
#include "twin/core/error.h"
#include "twin/plant/model_cache_repair.h"
#include "twin/run/remote.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/lab.h"

namespace twin::cli {
namespace {

bool WaitsForNobody(const scenario::Scenario& scenario, const run::RealtimeSettings& settings) {
  if (scenario.drive == scenario::Drive::kRemote) {
    return settings.remote.time == backend::RobotTime::kWall;
  }
  return scenario.drive == scenario::Drive::kRealtime;
}

scenario::DataDirectory DataOf(const RunFlags& flags, const Host& host) {
  return scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
}

/// With the device's own defaults: the scenario's parameters are of another one.
void ChooseDevice(const std::string& device, scenario::Scenario& scenario) {
  if (!scenario.operator_section) {
    throw InputError("--device goes with a scenario in which somebody leads: its section operator");
  }
  if (scenario.operator_section->device == device) return;
  scenario.operator_section->device = device;
  scenario.operator_section->parameters.clear();
  scenario.places.device = {};
}

}  // namespace

scenario::Scenario LoadWithFlags(const RunFlags& flags, const Host& host) {
  scenario::Scenario scenario = scenario::Load(flags.scenario);
  if (flags.lab) {
    scenario::ApplyLab(scenario::FindLab(*flags.lab, DataOf(flags, host).models), scenario);
  }
  if (flags.seed) scenario.seed = *flags.seed;
  if (flags.backend) ChooseBackend(*flags.backend, scenario);
  if (flags.drive) scenario.drive = scenario::DriveFromName(*flags.drive);
  if (flags.device) ChooseDevice(*flags.device, scenario);
  RequireRemoteFlags(flags, scenario);
  if (flags.clock_ppm) scenario.robot.clock_drift_ppm = *flags.clock_ppm;
  if (scenario.drive == scenario::Drive::kLockstep && (flags.ext_cpu || flags.int_cpu)) {
    throw InputError("--ext-cpu and --int-cpu go with --drive realtime: lockstep has one thread");
  }
  scenario.Validate();
  return scenario;
}

run::RealtimeSettings SettingsOf(const RunFlags& flags) {
  run::RealtimeSettings settings;
  settings.robot.cpu = flags.int_cpu;
  settings.threads.communication.cpu = flags.ext_cpu;
  if (flags.robot) {
    settings.remote = run::ParseRemote(*flags.robot, flags.robot_time.value_or("wall"));
  }
  return settings;
}

double PeakMemoryMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

std::filesystem::path UsableCache(const Host& host) {
  const auto note = [](std::string_view text) {
    Say(stderr, fmt::format("panda-twin: note: {}\n", text));
  };
  if (host.cache.empty() || !plant::RepairModelCache(host.cache, note)) return {};
  return host.cache;
}

run::RunFiles FilesOf(const RunFlags& flags, const Host& host) {
  const scenario::DataDirectory data = DataOf(flags, host);
  return {data.models, data.mesh_package, UsableCache(host), flags.rebuild_cache};
}

void RequirePrograms(const scenario::Scenario& scenario, bool wants_video, const Host& host) {
  if (scenario.drive != scenario::Drive::kRemote && wants_video &&
      scenario.plant.kind == robot::PlantKind::kMujoco) {
    RequireProgram("ffmpeg", host.path, "apt-get install ffmpeg, or run with --no-video");
  }
  if (scenario.record) {
    RequireProgram("gnuplot", host.path, "apt-get install gnuplot-nox, or say record: false");
  }
}

record::RunInfo InfoOf(const scenario::Scenario& scenario, const scenario::RobotData& robot) {
  return {scenario.name,
          scenario.seed,
          TWIN_VERSION,
          std::string(Name(scenario.drive)),
          scenario::ToYaml(scenario),
          record::RunLimits{robot.limits, robot.cartesian}};
}

void Connect(const scenario::Scenario& scenario, const RunFlags& flags, bool wants_video,
             run::RealtimeSettings& settings, std::optional<fci::Capture>& capture,
             const std::function<const backend::Connection&()>& connect) {
  if (scenario.drive != scenario::Drive::kRemote) {
    static_cast<void>(connect());
    return;
  }
  WarnIgnoredSettings(scenario, wants_video);
  if (flags.capture) settings.remote.capture = &capture.emplace(*flags.capture);
  TellReach(settings.remote, flags.allow_hardware, connect);
}

void BeginLog(RunRecords& records, const std::filesystem::path& path,
              const scenario::Scenario& scenario, const scenario::RobotData& robot,
              const run::RealtimeSettings& settings) {
  if (!scenario.record) return;
  records.Log(
      path, InfoOf(scenario, robot),
      WaitsForNobody(scenario, settings) ? record::FullRing::kDrop : record::FullRing::kWait);
}

void CarryOut(RunRecords& records, const ResultFolder& out, const InterruptGuard& interrupt,
              const std::function<void()>& work) {
  try {
    work();
  } catch (...) {
    records.Abandon();
    out.RemovePartial(records.log_failed());
    interrupt.ThrowIfInterrupted();
    throw;
  }
}

void TellIfWithoutMeshes(const scenario::Scenario& scenario,
                         const backend::Connection& connection) {
  if (scenario.drive == scenario::Drive::kRemote || connection.uses_meshes ||
      scenario.plant.kind != robot::PlantKind::kMujoco) {
    return;
  }
  Say(stderr,
      "panda-twin: note: the robot's meshes were not found; it is simulated and drawn in "
      "primitive shapes (scripts/setup fetches them; or name them with --meshes)\n");
}

std::filesystem::path OutOf(const scenario::Scenario& scenario, const RunFlags& flags) {
  return flags.out.empty() ? std::filesystem::path("out") / scenario.name : flags.out;
}

void LeaveFailure(const scenario::Scenario& scenario, const RunFlags& flags,
                  const std::string& failure) {
  try {
    ResultFolder out(OutOf(scenario, flags));
    out.Prepare();
    out.Clear();
    WriteWholeFile(out.scenario(), scenario::ToYaml(scenario));
    WriteWholeFile(out.summary(), FailureJson(scenario, failure));
  } catch (const EnvironmentError& error) {
    Say(stderr, fmt::format("panda-twin: note: {}\n", error.what()));
  }
}

void EvaluateDeviations(const std::vector<run::FollowedMotion>& motions, bool strict) {
  const auto exceeding = std::ranges::count_if(motions, &run::FollowedMotion::exceeds);
  if (exceeding == 0) return;
  const run::FollowedMotion& first = *std::ranges::find_if(motions, &run::FollowedMotion::exceeds);
  const std::string whose = motions.size() == 1
                                ? std::string()
                                : fmt::format("in {} of {} motions, first in {}: ", exceeding,
                                              motions.size(), first.name);
  const std::string text =
      fmt::format("the arm was off its path: {}{} (max_deviation)", whose, first.Excess());
  if (strict) throw RobotFault(text);
  std::fflush(stdout);
  Say(stderr, fmt::format("panda-twin: warning: {}\n", text));
}

void TellNotices(const std::vector<std::string>& workstation,
                 const std::vector<std::string>& robot) {
  for (const std::string& notice : workstation) {
    Say(stderr, fmt::format("panda-twin: note: workstation: {}\n", notice));
  }
  for (const std::string& notice : robot) {
    Say(stderr, fmt::format("panda-twin: note: robot: {}\n", notice));
  }
}

/// What was captured of a run that failed is wanted most. What fails here is told beside it.
void KeepAfterFailure(std::optional<fci::Capture>& capture) {
  if (!capture) return;
  try {
    FinishCapture(*capture);
  } catch (const EnvironmentError& error) {
    Say(stderr, fmt::format("panda-twin: note: {}\n", error.what()));
  }
}

}  // namespace twin::cli

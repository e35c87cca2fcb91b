#include "cli/remote_run.h"

#include <cstdio>

#include <fmt/format.h>

#include "cli/say.h"
#include "twin/core/error.h"
#include "twin/scenario/robot_data.h"

namespace twin::cli {
namespace {

void Print(const run::CheckLine& line) {
  Say(stdout, fmt::format("{:<6} {:<13} {}\n", line.ok ? "ok" : "FAILED", line.subject, line.text));
  std::fflush(stdout);
}

}  // namespace

void ChooseBackend(std::string_view backend, scenario::Scenario& scenario) {
  scenario.backend = backend;
  if (backend == scenario::kRemoteBackend) {
    scenario.drive = scenario::Drive::kRemote;
  } else if (scenario.drive == scenario::Drive::kRemote) {
    scenario.drive = scenario::Drive::kLockstep;
  }
}

void RequireRemoteFlags(const RunFlags& flags, const scenario::Scenario& scenario) {
  const bool is_remote = scenario.drive == scenario::Drive::kRemote;
  if (!is_remote && flags.drive && scenario.backend == scenario::kRemoteBackend) {
    throw InputError(fmt::format(
        "--drive {} contradicts backend fci, whose drive is remote; leave out --drive, or the "
        "backend",
        *flags.drive));
  }
  if (!is_remote && (flags.robot || flags.robot_time || flags.capture || flags.allow_hardware)) {
    throw InputError("--robot, --robot-time, --allow-hardware and --capture go with --backend fci");
  }
  if (is_remote && !flags.robot) {
    throw InputError(
        "backend fci needs --robot HOST[:PORT]: a robot's address, or that of panda-twin serve");
  }
  if (is_remote && flags.int_cpu) {
    throw InputError("--int-cpu is of a robot in this process; with backend fci leave it out");
  }
}

void SlowDown(scenario::Scenario& scenario, const std::filesystem::path& models, double share) {
  const scenario::RobotData robot =
      scenario::LoadRobotData(models, scenario.robot.model, scenario.robot.hand);
  run::SlowDown(scenario, robot, share);
}

void WarnIgnoredSettings(const scenario::Scenario& scenario, bool video) {
  for (const std::string& text : run::WithoutEffectThere(scenario)) {
    Say(stderr, fmt::format("panda-twin: note: without effect on this robot: {}\n", text));
  }
  if (!video) return;
  Say(stderr,
      "panda-twin: note: no video is made: nobody here sees the robot; run the scenario in the "
      "twin "
      "(without --backend) to see the motion\n");
}

void TellReach(const run::RemoteSettings& robot, bool allow_hardware,
               const std::function<const backend::Connection&()>& connect) {
  Say(stdout, "before the first motion; nothing of this moves the arm\n");
  bool is_twin = false;
  try {
    const backend::Connection& connection = connect();
    Print({"reach", true, connection.backend->Describe().robot});
    is_twin = connection.is_twin;
  } catch (const RobotFault&) {
    // The text is that of the error, which follows.
    Print(
        {"reach", false, fmt::format("{} is no robot that can be driven; see below", robot.host)});
    throw;
  }
  if (is_twin) return Print({"hardware", true, "none: it says that it is a twin"});
  if (allow_hardware) return Print({"hardware", true, "a real arm may move (--allow-hardware)"});
  Print({"hardware", false, "a real arm may move, and nothing allows that; see below"});
  throw InputError(
      fmt::format("--robot {}: what answers there does not say that it is a twin, so that a real "
                  "arm may move; clear its workspace, keep the user stop in your hand, and say "
                  "--allow-hardware",
                  robot.host));
}

void RequireReady(const std::function<bool(const run::TellCheck&)>& check) {
  int failed = 0;
  const bool ready = check([&failed](const run::CheckLine& line) {
    Print(line);
    failed += line.ok ? 0 : 1;
  });
  if (ready) return;
  throw RobotFault(
      fmt::format("{} of the checks before the first motion failed, see above; the arm was not "
                  "moved",
                  failed));
}

}  // namespace twin::cli

#include "cli/serve_flags.h"

#include <chrono>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"
#include "twin/loop/host_timing.h"
#include "twin/run/remote.h"
#include "twin/scenario/data_directory.h"

namespace twin::cli {
namespace {

/// Whether or not they are there.
bool IsSameFile(const std::filesystem::path& a, const std::filesystem::path& b) {
  return std::filesystem::weakly_canonical(a) == std::filesystem::weakly_canonical(b);
}

bool IsLockstep(const std::string& drive) {
  return scenario::DriveFromName(drive) == scenario::Drive::kLockstep;
}

std::string DescribeTime(const ServeFlags& flags, const ServeDrive& drive) {
  std::string text;
  if (!drive.is_lockstep()) {
    text = "the wall clock: a cycle every 1 ms, answered or not";
  } else if (drive.pace) {
    text = fmt::format("a cycle when the last state is answered, at most {} times the wall clock",
                       *drive.pace);
  } else {
    text = "a cycle when the last state is answered, as fast as answers come";
  }
  if (FreezesWhenIdle(flags)) text += "; none between motions";
  if (!drive.reason.empty()) {
    text += fmt::format("\n        as this host is {}\n        --drive and --pace decide instead",
                        drive.reason);
  }
  return text;
}

/// ", caps on speed, force and torque", as far as there are any.
std::string DescribeCaps(const model::LabLimits& limits) {
  std::vector<std::string_view> caps;
  if (limits.dq_max || limits.v_max || limits.w_max) caps.emplace_back("speed");
  if (limits.force_max) caps.emplace_back("force");
  if (limits.tau_max) caps.emplace_back("torque");
  return caps.empty() ? "" : fmt::format(", caps on {}", fmt::join(caps, ", "));
}

/// How programs made for the robot reach this one.
std::string DescribeClients(const server::ServedRobot& robot) {
  const fci::Endpoint arm = robot.arm();
  if (arm.port != fci::kArmPort) {
    return "  use   our own programs: libfranka and what is built on it know ports 1337 and 1338 "
           "alone\n";
  }
  const std::string at = arm.address == 0 ? "127.0.0.1" : fci::AddressText(arm.address);
  return fmt::format(
      "  use   libfranka 0.9  franka::Robot robot(\"{0}\", franka::RealtimeConfig::kIgnore);\n"
      "        panda-py       panda_py.Panda(\"{0}\")\n"
      "        libfranka-rs   franka::Robot::new(\"{0}\", RealtimeConfig::Ignore, None)\n"
      "        franka_ros     roslaunch franka_control franka_control.launch robot_ip:={0}\n",
      at);
}

}  // namespace

ServeDrive DriveOf(const ServeFlags& flags) {
  if (flags.drive) return {scenario::DriveFromName(*flags.drive), flags.pace, {}};
  if (flags.pace) return {scenario::Drive::kLockstep, flags.pace, {}};
  if (flags.clock_ppm) return {scenario::Drive::kRealtime, {}, {}};
  constexpr Duration kMeasured = std::chrono::milliseconds(500);
  const loop::JitterVerdict verdict = loop::Evaluate(loop::MeasureJitter(kMeasured));
  if (verdict.good) {
    // Clients need not have the priority that this measurement had.
    const loop::JitterVerdict ordinary =
        loop::EvaluateOrdinary(loop::MeasureOrdinaryWakeUps(kMeasured));
    if (!ordinary.good) return {scenario::Drive::kLockstep, 1.0, ordinary.text};
    return {scenario::Drive::kRealtime, {}, verdict.text};
  }
  return {scenario::Drive::kLockstep, 1.0, verdict.text};
}

scenario::Scenario ServedScenarioOf(const ServeFlags& flags, const ServeDrive& drive,
                                    const Host& host) {
  scenario::Scenario scenario = flags.scenario.empty()
                                    ? run::DefaultServed()
                                    : scenario::LoadServed(scenario::FindScenario(
                                          flags.scenario, DataOf(flags.data, host).models));
  ReplaceSite(flags.lab, flags.seed, flags.data, host, scenario);
  if (flags.scene) {
    std::error_code none;
    const bool is_here = std::filesystem::is_regular_file(*flags.scene, none);
    scenario.scene = is_here ? std::filesystem::absolute(*flags.scene) : *flags.scene;
  }
  if (flags.clock_ppm) scenario.robot.clock_drift_ppm = *flags.clock_ppm;
  scenario.backend = scenario::Scenario().backend;  // the served robot is simulated
  scenario.drive = drive.drive;
  return scenario;
}

bool FreezesWhenIdle(const ServeFlags& flags) {
  if (flags.idle == "run") return false;
  if (flags.idle == "freeze") return true;
  throw InputError(fmt::format("--idle: \"{}\" is neither run nor freeze", flags.idle));
}

model::LabLimits GuardOf(const ServeFlags& flags, const scenario::Scenario& scenario) {
  if (!flags.guard) return {};
  RefuseIf(scenario.limits.empty(),
           "--guard: there is nothing to guard, as neither scenario nor lab has a section limits; "
           "add one (docs/reference/limits.md), or leave out --guard");
  return scenario.limits;
}

ResetPolicy ResetPolicyOf(const ServeFlags& flags, const ServeDrive& drive) {
  if (flags.reset == "never") return ResetPolicy::kNever;
  if (flags.reset != "on-connect" && flags.reset != "on-command") {
    throw InputError(
        fmt::format("--reset: \"{}\" is none of never, on-connect and on-command", flags.reset));
  }
  RefuseIf(!drive.is_lockstep(),
           "--reset goes with --drive lockstep, with --pace or without: on the wall clock nothing "
           "begins anew");
  return flags.reset == "on-connect" ? ResetPolicy::kOnConnect : ResetPolicy::kOnCommand;
}

void RequireServeAgreement(const ServeFlags& flags) {
  RequirePageFlags(flags.page);
  const bool is_realtime = flags.drive && !IsLockstep(*flags.drive);
  const bool is_lockstep = flags.pace || (flags.drive && IsLockstep(*flags.drive));
  RefuseIf(FreezesWhenIdle(flags) && !is_lockstep,
           "--idle freeze goes with --drive lockstep: the wall clock never stands still");
  RefuseIf(flags.clock_ppm && is_lockstep,
           "--clock-ppm goes with --drive realtime: lockstep has one clock");
  RefuseIf(flags.pace && is_realtime, "--pace goes with --drive lockstep: real time has its own");
  if (flags.pace) RequireInRange("--pace", *flags.pace, 0.01, 100);
  if (!(flags.session_timeout >= 0.001 && flags.session_timeout <= 3600)) {
    throw InputError(fmt::format("--session-timeout is {} s; it must lie in [0.001, 3600] s",
                                 flags.session_timeout));
  }
  if (flags.log && flags.capture && IsSameFile(*flags.log, *flags.capture)) {
    throw InputError(fmt::format("--log and --capture both name {}; give each a file of its own",
                                 flags.log->string()));
  }
  RefuseIf(flags.out && flags.log,
           "--out keeps the log too, as run.mcap; leave out --log, or --out");
  RefuseIf(flags.no_video && !flags.out, "--no-video goes with --out");
  RequireDuration(flags.seconds);
}

std::string IntroductionOf(const ServeFlags& flags, const ServeDrive& drive,
                           const scenario::Scenario& scenario, const server::ServedRobot& robot) {
  std::string text = fmt::format("panda-twin serves {} ({}), drive {}\n", scenario.robot.model,
                                 robot.plant_name(), scenario.drive_name());
  text += fmt::format("  time  {}\n", DescribeTime(flags, drive));
  if (flags.viability) {
    text += fmt::format("  commands are kept within the limits, up to {} lost in a row\n",
                        *flags.viability);
  }
  if (flags.guard) {
    text += fmt::format("  guard the robot stops a motion before it breaks a limit: regions {}{}\n",
                        scenario.limits.regions.size(), DescribeCaps(scenario.limits));
  }
  text += fmt::format("  arm   {}\n", fci::ToString(robot.arm()));
  if (const auto hand = robot.hand()) text += fmt::format("  hand  {}\n", fci::ToString(*hand));
  text += DescribeClients(robot);
  text += flags.seconds ? fmt::format("  ends  after {} s, or on Ctrl-C\n", *flags.seconds)
                        : "  ends  on Ctrl-C\n";
  text += fmt::format("  {}\n", DescribeAccess(flags.network));
  return text;
}

}  // namespace twin::cli

#include "application/robot_start.h"

#include <string>

#include <fmt/format.h>

#include "twin/core/calendar_clock.h"
#include "twin/core/error.h"
#include "twin/run/run.h"

namespace twin::application {
namespace {

/// The check of the start position, by run::CheckStart.
constexpr std::string_view kStartCheck = "start";

/// What RequireFree() looks at in a scenario, in words.
std::string PathText(const scenario::Scenario& scenario) {
  const scenario::MotionSection& motion = scenario.motion;
  if (!motion.touches.empty()) return fmt::format("not checked: {}", motion.touches);
  if (scenario.application) return "an application plans its motions as it goes";
  if (motion.plan) return "planned around what the scenario says stands there";
  if (!motion.poses.empty()) return "not checked: of poses the robot chooses the joints";
  if (scenario.base && !scenario.base->drive.empty()) return "not checked: the base drives";
  return "touches neither the arm itself nor floor, scene and objects";
}

}  // namespace

std::string LineOf(const run::CheckLine& line) {
  return fmt::format("{:<6} {:<13} {}\n", line.ok ? "ok" : "FAILED", line.subject, line.text);
}

void RequireAllowed(bool is_allowed, const backend::RobotAddress& robot) {
  if (is_allowed) return;
  throw InputError(fmt::format(
      "--robot {}: what answers there does not say that it is a twin, so that a real arm may "
      "move; clear its workspace, keep the user stop in your hand, and say --allow-hardware",
      NameOf(robot)));
}

std::string NameOf(const backend::RobotAddress& address) {
  return fmt::format("{}:{}", address.host, address.arm_port);
}

void RobotStart::Print(const run::CheckLine& line) {
  if (!line.ok) ++failed_;
  inputs_.console.Say(LineOf(line));
}

void RobotStart::CheckPath() {
  try {
    run::RequireFree(inputs_.scenario, inputs_.files);
    Print({"path", true, PathText(inputs_.scenario)});
  } catch (const InputError& error) {
    Print({"path", false, error.what()});
    if (!inputs_.options.hardware.check_only) throw;
  }
}

void RobotStart::CheckRehearsal() {
  const HardwareOptions& hardware = inputs_.options.hardware;
  const run::CheckLine line =
      hardware.no_rehearsal.empty()
          ? run::CheckRehearsal(*hardware.history, hardware.rehearsal)
          : run::CheckLine{"rehearsal", true, "none demanded: " + hardware.no_rehearsal};
  Print(line);
  if (!line.ok && !hardware.check_only) throw InputError("no rehearsal: " + line.text);
  Print({"speed", true, hardware.speed});
}

void RobotStart::Reach(const std::function<const backend::Connection&()>& connect) {
  const std::string robot = NameOf(inputs_.options.settings.remote);
  inputs_.console.Say("before the first motion; nothing of this moves the arm\n");
  Print({"lab", true, inputs_.options.site});
  CheckPath();
  if (inputs_.options.hardware.allowed) CheckRehearsal();
  bool is_twin = false;
  try {
    const backend::Connection& connection = connect();
    Print({"reach", true, connection.backend->Describe().robot});
    is_twin = connection.is_twin;
  } catch (const RobotFault&) {
    Print({"reach", false, fmt::format("{} cannot be driven; see below", robot)});
    throw;
  }
  CheckHardware(is_twin);
}

void RobotStart::CheckHardware(bool is_twin) {
  const HardwareOptions& hardware = inputs_.options.hardware;
  const bool is_allowed = is_twin || hardware.allowed;
  Print({"hardware", is_allowed,
         is_twin            ? "none: it says that it is a twin"
         : hardware.allowed ? "a real arm may move (--allow-hardware)"
                            : "a real arm may move, and nothing allows that; see below"});
  RequireAllowed(is_allowed, inputs_.options.settings.remote);
}

void RobotStart::RequireReady(const std::function<bool(const run::TellCheck&)>& check) {
  bool is_at_start = true;
  const bool ready = check([this, &is_at_start](const run::CheckLine& line) {
    Print(line);
    if (line.subject == kStartCheck) is_at_start = line.ok;
  });
  if (ready && failed_ == 0) return;
  const std::string& to_start = inputs_.options.hardware.to_start;
  throw RobotFault(fmt::format(
      "{} of the checks before the first motion failed, see above; the arm was not "
      "moved{}",
      failed_,
      is_at_start || to_start.empty() ? std::string()
                                      : fmt::format("; bring it to the start: {}", to_start)));
}

void RobotStart::Confirm() {
  const HardwareOptions& hardware = inputs_.options.hardware;
  if (!hardware.confirm) return;
  hardware.confirm(fmt::format("{} on {}, speed {}", inputs_.scenario.name,
                               NameOf(inputs_.options.settings.remote), hardware.speed));
}

nlohmann::ordered_json RobotStart::Record() const {
  const HardwareOptions& hardware = inputs_.options.hardware;
  nlohmann::ordered_json record{{"robot", NameOf(inputs_.options.settings.remote)},
                                {"max_speed", hardware.rehearsal.max_speed},
                                {"scenario_hash", hardware.rehearsal.hash},
                                {"rehearsed", nullptr},
                                {"no_rehearsal", hardware.no_rehearsal},
                                {"confirmed", static_cast<bool>(hardware.confirm)}};
  if (!hardware.no_rehearsal.empty()) return record;
  if (const auto last = hardware.history->Find(hardware.rehearsal.hash, {})) {
    record["rehearsed"] = FormatUtc(last->ended);
  }
  return record;
}

}  // namespace twin::application

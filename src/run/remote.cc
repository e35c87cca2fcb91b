#include "twin/run/remote.h"

#include <numbers>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/fci/capture.h"
#include "twin/fci/protocol.h"
#include "twin/run/run.h"

namespace twin::run {
namespace {

backend::RobotTime ParseTime(std::string_view time) {
  if (time == "auto") return backend::RobotTime::kAsItSays;
  if (time == "wall") return backend::RobotTime::kWall;
  if (time == "states") return backend::RobotTime::kStates;
  throw InputError(fmt::format(
      "--robot-time \"{}\" is unknown; accepted: auto (states where the robot says that "
      "it is a twin served in lockstep, else wall), wall, states",
      time));
}

std::uint16_t ParsePort(std::string_view text, std::string_view robot) {
  const auto port = ParseInteger<std::uint16_t>(text).value_or(0);
  if (port > 0 && port < 65535) return port;
  throw InputError(fmt::format("--robot \"{}\": \"{}\" is no port; give one in [1, 65534], or none",
                               robot, text));
}

/// Whether the link does nothing to messages.
bool IsIdeal(scenario::LinkSection link) {
  const scenario::LinkSection ideal;
  link.d_INT = ideal.d_INT;
  return link == ideal;
}

bool TakesTime(const scenario::Scenario& scenario) {
  const scenario::ControllerSection& controller = scenario.controller;
  return scenario.tick.cost != scenario::Delay() || controller.cost != scenario::Delay() ||
         controller.wake_delay != scenario::Delay();
}

/// What is set in the robot's own controller and by no request.
bool HasOwnLaws(const scenario::OnboardSection& onboard) {
  const scenario::OnboardSection usual;
  return onboard.damping_ratio != usual.damping_ratio ||
         onboard.abort_after_lost != usual.abort_after_lost ||
         onboard.friction_compensation != usual.friction_compensation;
}

}  // namespace

backend::RobotAddress ParseRemote(std::string_view robot, std::string_view time) {
  backend::RobotAddress settings{.host = {}, .arm_port = fci::kArmPort, .time = ParseTime(time)};
  const std::size_t colon = robot.rfind(':');
  settings.host = std::string(robot.substr(0, colon));
  if (settings.host.empty()) {
    throw InputError(fmt::format("--robot \"{}\" names no host; give HOST or HOST:PORT", robot));
  }
  if (colon != std::string_view::npos) {
    settings.arm_port = ParsePort(robot.substr(colon + 1), robot);
  }
  return settings;
}

std::vector<std::string> WithoutEffectThere(const scenario::Scenario& scenario) {
  std::vector<std::string> lines;
  const auto add_if = [&lines](bool present, const char* text) {
    if (present) lines.emplace_back(text);
  };
  add_if(
      !(scenario.plant == scenario::PlantSection()) ||
          (!scenario.scene.empty() && !scenario.motion.plan),
      "plant, scene: the robot and its surroundings are what they are; base_tilt, mass_scale and "
      "robot.load are compared with the torques at rest");
  add_if(scenario.robot.clock_drift_ppm != 0 ||
             scenario.robot.catch_up != scenario::RobotSection().catch_up,
         "robot.clock_drift, robot.catch_up: they describe a simulated robot");
  add_if(!IsIdeal(scenario.link), "link: the network between is what it is");
  add_if(TakesTime(scenario),
         "tick.cost, controller.cost, controller.wake_delay: what things cost "
         "is what passes");
  add_if(!scenario.perturbations.empty(), "perturbations: only a simulated arm is pushed");
  add_if(!scenario.panel.empty(), "panel: only you press the robot's buttons");
  add_if(HasOwnLaws(scenario.onboard),
         "onboard.damping_ratio, onboard.abort_after_lost, onboard.friction_compensation: no "
         "request sets them");
  return lines;
}

scenario::Scenario DefaultServed() {
  constexpr double kPi = std::numbers::pi;
  scenario::Scenario scenario;
  scenario.name = "serve";
  const JointVector ready{0, -kPi / 4, 0, -3 * kPi / 4, 0, kPi / 2, kPi / 4};
  scenario.robot.q_start = ready;
  scenario.motion.waypoints = {{.q = ready}, {.q = ready}};  // none of its own: its client's
  return scenario;
}

void SlowDown(scenario::Scenario& scenario, const scenario::RobotData& robot, double share) {
  RequireInRange("--max-speed", share, 1e-3, 1);
  if (share == 1) return;
  const auto slower = [share](Duration time) { return FromSeconds(ToSeconds(time) / share); };
  if (scenario.motion.plan) {
    scenario.motion.plan->stretch /= share;
    return;
  }
  const Duration total = slower(MakeTrajectory(scenario, robot).duration());
  reference::Timing& timing = scenario.motion.timing;
  std::optional<Duration> last;
  for (reference::Waypoint& waypoint : scenario.motion.waypoints) {
    if (!waypoint.at) continue;
    waypoint.at = slower(*waypoint.at);
    last = waypoint.at;
  }
  for (scenario::PoseStep& step : scenario.motion.poses) {
    if (!step.at) continue;
    step.at = slower(*step.at);
    last = step.at;
  }
  // Of timed points the last one's time is the duration, where one is given.
  if (!last) timing.duration = total;
  if (last && timing.duration) timing.duration = last;
  for (scenario::HandEvent& event : scenario.hand) event.at = slower(event.at);
}

void FinishCapture(fci::Capture& capture, const std::function<void(std::string_view)>& note) {
  const std::uint64_t dropped = capture.Finish();
  if (dropped == 0) return;
  note(fmt::format("the capture lacks {} datagrams: the disk was slower than the wire", dropped));
}

}  // namespace twin::run

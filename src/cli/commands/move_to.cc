#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/hardware_flags.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/application/record_run.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"
#include "twin/reference/trajectory.h"
#include "twin/run/remote.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

struct MoveToFlags {
  std::vector<std::string> goal;  ///< a pose, or "start-of" and a scenario
  std::string from = "ready";     ///< in the twin
  std::string in;                 ///< scenario whose scene, objects and hand are around the arm
  std::optional<std::string> lab;
  std::string backend = "mujoco";
  HardwareFlags hardware;
  double max_speed = 0.1;  ///< share of the planner's speed
  std::filesystem::path out = "out/move_to";
  bool no_video = false;
  DataFlags data;
};

constexpr std::string_view kStartOf = "start-of";

/// @param text  "ready", or 7 angles: "0,-0.785,0,-2.356,0,1.571,0.785", with "deg" behind in
/// degrees.
JointVector ParsePose(const std::string& text) {
  if (text == "ready") return *run::DefaultServed().robot.q_start;
  const bool in_degrees = text.ends_with("deg");
  const double factor = UnitFactor(in_degrees ? "deg" : "rad", Dimension::kAngle);
  std::string_view rest = text;
  if (in_degrees) rest.remove_suffix(3);
  std::vector<double> angles;
  try {
    while (true) {
      const std::size_t comma = rest.find(',');
      angles.push_back(factor * ParseNumber(rest.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      rest.remove_prefix(comma + 1);
    }
  } catch (const InputError&) {
    angles.clear();  // told below, with what a pose is
  }
  if (angles.size() == kJoints) {
    JointVector q{};
    std::ranges::copy(angles, q.begin());
    return q;
  }
  throw InputError(fmt::format(
      "\"{}\" is not a pose; give ready, or 7 angles with commas and without spaces, in "
      "rad or with deg behind: 0,-45,0,-135,0,90,45deg",
      text));
}

/// Where the arm stands when this scenario begins.
JointVector StartOf(const scenario::Scenario& scenario) {
  if (!scenario.motion.waypoints.empty()) return scenario.motion.waypoints.front().q;
  if (scenario.robot.q_start) return *scenario.robot.q_start;
  throw InputError(
      fmt::format("scenario {} does not say where its arm starts (robot.q_start)", scenario.name));
}

bool IsStartOf(const MoveToFlags& flags) {
  if (flags.goal.front() != kStartOf) {
    RefuseIf(flags.goal.size() != 1, "move-to takes one pose, or start-of SCENARIO");
    return false;
  }
  RefuseIf(flags.goal.size() != 2, "start-of needs a scenario: move-to start-of FILE");
  RefuseIf(!flags.in.empty(), "--in goes with a pose; start-of has its scenario's surroundings");
  return true;
}

/// What stands around the arm, of whatever scenario was named, and no motion.
scenario::Scenario Surroundings(const MoveToFlags& flags, const std::string& named,
                                const Host& host) {
  scenario::Scenario scenario = run::DefaultServed();
  scenario.motion.waypoints.assign(2, {.q = *scenario.robot.q_start});  // a lab wants a motion
  if (!named.empty()) scenario = LoadScenario(named, flags.data, host);
  ReplaceSite(flags.lab, {}, flags.data, host, scenario);
  return scenario;
}

/// The motion in place of the scenario's own.
scenario::Scenario Moving(const scenario::Scenario& around, const JointVector& start,
                          const JointVector& goal, const MoveToFlags& flags) {
  scenario::Scenario scenario;
  scenario.name = "move_to";
  scenario.backend = flags.backend;
  scenario.seed = around.seed;
  scenario.scene = around.scene;
  scenario.objects = around.objects;
  scenario.robot = around.robot;
  scenario.base = around.base;
  if (scenario.base) scenario.base->drive.clear();
  scenario.plant = around.plant;
  scenario.link = around.link;
  scenario.onboard = around.onboard;
  scenario.limits = around.limits;
  scenario.render = around.render;
  scenario.places = around.places;
  scenario.robot.q_start = start;
  scenario.motion.plan.emplace();
  scenario.motion.plan->goal = goal;
  scenario.motion.plan->stretch = 1 / flags.max_speed;
  scenario.Validate();
  return scenario;
}

/// Where the robot at the other end of the wire stands. Nothing is asked of it but states.
JointVector CurrentPosition(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                            const run::RunFiles& files, const run::RealtimeConfig& settings) {
  scenario::Scenario standing = scenario;
  standing.motion.plan.reset();
  const run::Session session(standing, catalogue, files, nullptr, settings);
  return CurrentPositionOf(session, settings.remote);
}

double LargestDistance(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

application::HardwareOptions Demands(const MoveToFlags& flags, Terminal& terminal) {
  application::HardwareOptions options;
  options.allowed = flags.hardware.allow;
  options.no_rehearsal = "move-to plans from where the arm stands";
  options.speed = fmt::format("{:.3g} of the planner's (--max-speed)", flags.max_speed);
  options.rehearsal.max_speed = flags.max_speed;
  if (flags.hardware.allow && !flags.hardware.yes) {
    options.confirm = [&terminal](std::string_view what) { terminal.ConfirmMotion(what); };
  }
  return options;
}

int MoveTo(const MoveToFlags& flags, const Program& program) {
  RequireInRange("--max-speed", flags.max_speed, 1e-3, 1);
  const bool is_start_of = IsStartOf(flags);
  const scenario::Scenario around =
      Surroundings(flags, is_start_of ? flags.goal.back() : flags.in, program.host);
  const JointVector goal = is_start_of ? StartOf(around) : ParsePose(flags.goal.front());
  scenario::Scenario scenario = Moving(around, ParsePose(flags.from), goal, flags);
  RequireHardwareFlags(flags.hardware, scenario);
  Terminal terminal(program.log, program.is_quiet());
  const run::RunFiles files = FilesOf(flags.data, program);
  application::RunOptions options;
  options.scenario = is_start_of ? flags.goal.back() : flags.in;
  options.out = flags.out;
  options.site = flags.lab ? "lab " + *flags.lab : "none";
  options.makes_video = !flags.no_video;
  options.hardware = Demands(flags, terminal);
  if (scenario.is_remote()) {
    options.settings.remote =
        run::ParseRemote(*flags.hardware.robot, flags.hardware.robot_time.value_or("auto"));
    scenario.robot.q_start = CurrentPosition(scenario, program.catalogue, files, options.settings);
  }
  if (LargestDistance(*scenario.robot.q_start, goal) <= reference::kStartTolerance) {
    terminal.Say("the arm stands there already\n");
    return kOk;
  }
  application::RecordRun({scenario, options, files, program.catalogue, terminal});
  return kOk;
}

}  // namespace

void AddMoveTo(CLI::App& app, Program& program) {
  const auto [move, flags] =
      AddCommand(app, program, "move-to",
                 "Bring the arm to a pose: planned around what stands there, slowly", &MoveTo);
  Add(move, "goal POSE|start-of SCENARIO", flags.goal,
      "ready; 7 angles with commas, in rad or with deg behind; or where a scenario starts")
      ->required()
      ->expected(1, 2);
  Add(move, "--in SCENARIO", flags.in,
      "What stands around the arm, and its hand and load, are this scenario's (default: a floor)");
  AddLab(move, flags.lab);
  Add(move, "--backend mujoco|fci", flags.backend, "The twin, or a robot on the network")
      ->check(CLI::IsMember({"mujoco", "fci"}).description(""))
      ->capture_default_str();
  AddRobot(move, flags.hardware);
  Add(move, "--from POSE", flags.from, "mujoco: where the arm stands")->capture_default_str();
  Add(move, "--max-speed F", flags.max_speed, "Share of the planner's speed, in [0.001, 1]")
      ->capture_default_str();
  Add(move, "--out DIR", flags.out, "Folder of results")->capture_default_str();
  move.add_flag("--no-video", flags.no_video, "Make no video and no contact sheet");
  AddData(move, flags.data);
}

}  // namespace twin::cli

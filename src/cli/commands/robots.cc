#include <algorithm>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands/commands.h"
#include "cli/shared_flags.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/robot_identity.h"

namespace twin::cli {
namespace {

struct RobotsFlags {
  std::string robot;  ///< which to show; empty: list them all
  DataFlags data;
};

std::string KindOf(const scenario::RobotIdentity& robot) {
  if (robot.protocol == 0) return std::string(Name(robot.kind));
  return fmt::format("{}, FCI protocol {}", Name(robot.kind), robot.protocol);
}

void List(const std::filesystem::path& models) {
  const auto robots = scenario::ListRobots(models);
  std::size_t width = 0;
  for (const auto& robot : robots) width = std::max(width, robot.name.size());
  for (const auto& robot : robots) {
    Say(stdout, fmt::format("{:<{}}  {} ({})\n", robot.name, width, robot.title, KindOf(robot)));
  }
  Say(stdout, "panda-twin robots NAME shows one's figures and where they come from\n");
}

std::string LimitsOf(const scenario::RobotData& robot) {
  std::string text;
  const auto joints = [&text](std::string_view name, std::string_view unit, const JointVector& v) {
    text += fmt::format("  {:<9} {:>8.6g} {}\n", name, fmt::join(v, " "), unit);
  };
  const JointLimits& limits = robot.limits;
  joints("q_min", "rad", limits.q_min);
  joints("q_max", "rad", limits.q_max);
  joints("dq_max", "rad/s", limits.dq_max);
  joints("ddq_max", "rad/s^2", limits.ddq_max);
  joints("dddq_max", "rad/s^3", limits.dddq_max);
  joints("tau_max", "Nm", limits.tau_max);
  joints("dtau_max", "Nm/s", limits.dtau_max);
  if (limits.deceleration != JointVector{}) {
    joints("offset", "rad/s", limits.velocity_offset);
    joints("decel", "rad/s^2", limits.deceleration);
  }
  joints("rotor", "kg m^2", robot.rotor_inertia);
  const auto bound = [&text](std::string_view name, std::string_view unit,
                             const CartesianBound& of) {
    text += fmt::format("  {:<11} {:g} {}/s, {:g} {}/s^2, {:g} {}/s^3\n", name, of.dp_max, unit,
                        of.ddp_max, unit, of.dddp_max, unit);
  };
  bound("translation", "m", robot.cartesian.translation);
  bound("rotation", "rad", robot.cartesian.rotation);
  bound("elbow", "rad", robot.cartesian.elbow);
  return text;
}

void Show(const std::filesystem::path& models, const std::string& name) {
  const scenario::RobotIdentity robot = scenario::LoadRobotIdentity(models, name);
  std::string text = fmt::format("{}: {} ({})\n{}\n", robot.name, robot.title, KindOf(robot),
                                 (models / "robots" / name).string());
  if (robot.kind == scenario::RobotKind::kArm) {
    text += "\nlimits and drives, joints 1 to 7:\n" +
            LimitsOf(scenario::LoadRobotData(models, name, plant::HandKind::kNone));
  }
  text += "\nsources:\n";
  for (const scenario::FigureSource& one : robot.sources) {
    text += fmt::format("- {}\n    {}\n", one.figures, one.source);
  }
  Say(stdout, text);
}

int ShowRobots(const RobotsFlags& flags, const Program& program) {
  const std::filesystem::path models = DataOf(flags.data, program.host).models;
  if (flags.robot.empty()) {
    List(models);
  } else {
    Show(models, flags.robot);
  }
  FinishOutput();
  return kOk;
}

}  // namespace

void AddRobots(CLI::App& app, Program& program) {
  const auto [robots, flags] = AddCommand(
      app, program, "robots",
      "List the robots it knows, or show one's figures and where they come from", &ShowRobots);
  Add(robots, "robot NAME", flags.robot, "Which to show: a folder below models/robots");
  AddData(robots, flags.data);
}

}  // namespace twin::cli

#include "cli/serve_flags.h"

#include <cstdint>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/fci/protocol.h"
#include "twin/model/lab_limits.h"
#include "twin/server/served_robot.h"

namespace twin::cli {
namespace {

std::string DescribeTime(const ServeFlags& flags, const application::ServeDrive& drive) {
  std::string text;
  if (!drive.is_lockstep()) {
    text = "the wall clock: a cycle every 1 ms, answered or not";
  } else if (drive.pace) {
    text = fmt::format("a cycle when the last state is answered, at most {} times the wall clock",
                       *drive.pace);
  } else {
    text = "a cycle when the last state is answered, as fast as answers come";
  }
  if (flags.FreezesWhenIdle()) text += "; none between motions";
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
std::string DescribeClients(const server::ServedRobot& robot, std::uint16_t protocol) {
  const fci::Endpoint arm = robot.arm();
  if (arm.port != fci::kArmPort) {
    return "  use   our own programs: libfranka and what is built on it know ports 1337 to 1339 "
           "alone\n";
  }
  const std::string at = arm.address == 0 ? "127.0.0.1" : fci::AddressText(arm.address);
  if (protocol == fci::VersionOf(fci::Protocol::k10)) {
    return fmt::format(
        "  use   libfranka 0.18 to 0.21  franka::Robot robot(\"{0}\", "
        "franka::RealtimeConfig::kIgnore);\n"
        "        pylibfranka    pylibfranka.Robot(\"{0}\", pylibfranka.RealtimeConfig.kIgnore)\n"
        "        franky         franky.Robot(\"{0}\", realtime_config=franky.RealtimeConfig.Ignore)\n"
        "        franka_ros2    ros2 launch franka_bringup franka.launch.py robot_ip:={0}\n",
        at);
  }
  return fmt::format(
      "  use   libfranka 0.9  franka::Robot robot(\"{0}\", franka::RealtimeConfig::kIgnore);\n"
      "        panda-py       panda_py.Panda(\"{0}\")\n"
      "        libfranka-rs   franka::Robot::new(\"{0}\", RealtimeConfig::Ignore, None)\n"
      "        franka_ros     roslaunch franka_control franka_control.launch robot_ip:={0}\n",
      at);
}

}  // namespace

void RequireServeAgreement(const ServeFlags& flags) {
  RequirePageFlags(flags.page);
  RequireRosFlags(flags.ros);
  flags.Validate();
  RequireDuration(flags.seconds);
}

std::string IntroductionOf(const ServeFlags& flags, application::ServedSession& session) {
  const scenario::Scenario& scenario = session.scenario();
  const server::ServedRobot& robot = session.robot();
  std::string text = fmt::format("panda-twin serves {} ({}), drive {}\n", scenario.robot.model,
                                 robot.plant_name(), scenario.drive_name());
  text += fmt::format("  time  {}\n", DescribeTime(flags, session.drive()));
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
  text += DescribeClients(robot, session.robot_data().protocol);
  text += flags.seconds ? fmt::format("  ends  after {} s, or on Ctrl-C\n", *flags.seconds)
                        : "  ends  on Ctrl-C\n";
  text += fmt::format("  {}\n", DescribeAccess(flags.network));
  return text;
}

}  // namespace twin::cli

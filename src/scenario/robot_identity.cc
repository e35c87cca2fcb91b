#include "twin/scenario/robot_identity.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "scenario/robot_folders.h"
#include "scenario/schema.h"
#include "twin/fci/protocol.h"

namespace twin::scenario {
namespace {

constexpr const char* kFile = "robot.yaml";
constexpr std::uint16_t kFirstProtocol = fci::VersionOf(fci::Protocol::k5);
constexpr std::uint16_t kLastProtocol = fci::VersionOf(fci::Protocol::k10);
constexpr std::array<Spelling<bool>, 2> kModels{{{"library", true}, {"urdf", false}}};
constexpr std::array<Spelling<RobotKind>, 3> kKinds{
    {{"arm", RobotKind::kArm}, {"hand", RobotKind::kHand}, {"base", RobotKind::kBase}}};

RobotIdentity Read(const std::filesystem::path& file, const std::string& folder) {
  RobotIdentity robot;
  Map map;
  map.Require("robot", Text(robot.name), "Name of its folder.");
  map.Require("title", Text(robot.title), "Its name for people.");
  map.Require("kind", Choice(robot.kind, kKinds), "What it is.");
  map.Add("protocol", Integer(robot.protocol, kFirstProtocol, kLastProtocol),
          "Version of the Franka Control Interface that an arm speaks: 5 or 10.");
  map.Add("model", Choice(robot.has_library_model, kModels),
          "By which masses INT reckons: those of the Panda's model library, or of the URDF.");
  const auto source = [](FigureSource& one) {
    return Section([&one](Map& of) {
      of.Require("figures", Text(one.figures));
      of.Require("source", Text(one.source));
    });
  };
  map.Require("sources", List(robot.sources, source), "Where its figures come from.");
  const YamlNode node = YamlNode::ParseFile(file.string());
  map.Read(node);
  if (robot.name != folder) {
    node.Fail(
        fmt::format("robot: \"{}\" is in the folder {}; they must agree", robot.name, folder));
  }
  if ((robot.kind == RobotKind::kArm) != (robot.protocol != 0)) {
    node.Fail("protocol: an arm has one, and nothing else has");
  }
  if (robot.protocol > kFirstProtocol && robot.protocol < kLastProtocol) {
    node.Fail(fmt::format("protocol: {} is none that the program speaks; these are {} and {}",
                          robot.protocol, kFirstProtocol, kLastProtocol));
  }
  if (robot.protocol == kLastProtocol && robot.has_library_model) {
    node.Fail(
        "protocol: 10 has no model library, its clients reckon by the URDF: say model: urdf; a "
        "Panda speaks protocol 5");
  }
  return robot;
}

}  // namespace

std::string_view Name(RobotKind kind) noexcept {
  return std::ranges::find(kKinds, kind, &Spelling<RobotKind>::second)->first;
}

RobotIdentity LoadRobotIdentity(const std::filesystem::path& models, std::string_view name) {
  const std::filesystem::path robots = models / "robots";
  RequireFolder(robots, name, kFile, "robot");
  return Read(robots / name / kFile, std::string(name));
}

std::vector<RobotIdentity> ListRobots(const std::filesystem::path& models) {
  std::vector<RobotIdentity> robots;
  for (const std::string& name : FoldersWith(models / "robots", kFile)) {
    robots.push_back(Read(models / "robots" / name / kFile, name));
  }
  return robots;
}

}  // namespace twin::scenario

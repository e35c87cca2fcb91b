#include <algorithm>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/yaml_node.h"
#include "twin/core/error.h"
#include "twin/scenario/base_section.h"

namespace twin::scenario {
namespace {

constexpr double kLeast = 1e-3;
constexpr double kMost = 1e3;
constexpr const char* kDataFile = "base.yaml";

/// The names of the bases there are.
std::vector<std::string> BaseNames(const std::filesystem::path& robots) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(robots, error)) {
    if (std::filesystem::exists(entry.path() / kDataFile, error)) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

onboard::BaseAcceleration ReadAcceleration(const YamlNode& node) {
  const YamlMap map = node.Map({"v", "w"});
  return {map.Require("v").Quantity(Dimension::kAcceleration, kLeast, kMost),
          map.Require("w").Quantity(Dimension::kAngularAcceleration, kLeast, kMost)};
}

onboard::BaseConfig ReadBaseConfig(const std::filesystem::path& file) {
  const YamlMap map = YamlNode::ParseFile(file.string())
                          .Map({"base", "wheels", "most", "acceleration", "watchdog"});
  onboard::BaseConfig config;
  const YamlMap wheels = map.Require("wheels").Map({"radius", "track", "track_factor", "torque"});
  config.wheel_radius = wheels.Require("radius").Quantity(Dimension::kLength, kLeast, kMost);
  config.track = wheels.Require("track").Quantity(Dimension::kLength, kLeast, kMost);
  config.track_factor = wheels.Require("track_factor").Number(1, 10);
  config.tau_max = wheels.Require("torque").Quantity(Dimension::kTorque, kLeast, kMost);
  const YamlMap most = map.Require("most").Map({"v", "w"});
  config.most = {most.Require("v").Quantity(Dimension::kVelocity, kLeast, kMost),
                 most.Require("w").Quantity(Dimension::kAngularVelocity, kLeast, kMost)};
  const YamlMap acceleration = map.Require("acceleration").Map({"ordinary", "lost", "emergency"});
  config.ordinary = ReadAcceleration(acceleration.Require("ordinary"));
  config.lost = ReadAcceleration(acceleration.Require("lost"));
  config.emergency = ReadAcceleration(acceleration.Require("emergency"));
  config.watchdog = map.Require("watchdog").Time(kCycle, std::chrono::seconds(10));
  return config;
}

}  // namespace

BaseData LoadBaseData(const std::filesystem::path& models, std::string_view name) {
  const std::filesystem::path robots = models / "robots";
  const std::vector<std::string> names = BaseNames(robots);
  if (std::ranges::find(names, name) == names.end()) {
    throw InputError(fmt::format("base.model: \"{}\" is unknown; {} has: {}", name, robots.string(),
                                 fmt::join(names, ", ")));
  }
  const std::filesystem::path folder = robots / name;
  return {.urdf = folder / (std::string(name) + ".urdf"),
          .config = ReadBaseConfig(folder / kDataFile)};
}

}  // namespace twin::scenario

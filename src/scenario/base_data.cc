#include <algorithm>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/schema.h"
#include "twin/core/error.h"
#include "twin/scenario/base_section.h"

namespace twin::scenario {

using enum Dimension;

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

Value Most(double& value, Dimension dimension) {
  return Quantity(value, dimension, kLeast, kMost);
}

Value AccelerationOf(onboard::BaseAcceleration& acceleration) {
  return Section([&acceleration](Map& map) {
    map.Require("v", Most(acceleration.dv, kAcceleration));
    map.Require("w", Most(acceleration.dw, kAngularAcceleration));
  });
}

void Describe(Map& map, onboard::BaseConfig& config) {
  map.Add("base", Anything(), "Its name.");
  const auto wheels = [&config](Map& of) {
    of.Add("radius", Most(config.wheel_radius, kLength));
    of.Add("track", Most(config.track, kLength));
    of.Add("track_factor", Number(config.track_factor, 1, 10));
    of.Add("torque", Most(config.tau_max, kTorque));
    of.RequireAll();
  };
  const auto most = [&config](Map& of) {
    of.Require("v", Most(config.most.v, kVelocity));
    of.Require("w", Most(config.most.w, kAngularVelocity));
  };
  const auto acceleration = [&config](Map& of) {
    of.Add("ordinary", AccelerationOf(config.ordinary));
    of.Add("lost", AccelerationOf(config.lost));
    of.Add("emergency", AccelerationOf(config.emergency));
    of.RequireAll();
  };
  map.Require("wheels", Section(wheels));
  map.Require("most", Section(most));
  map.Require("acceleration", Section(acceleration));
  map.Require("watchdog", TimeSpan(config.watchdog, kCycle, std::chrono::seconds(10)));
}

onboard::BaseConfig ReadBaseConfig(const std::filesystem::path& file) {
  onboard::BaseConfig config;
  Map map;
  Describe(map, config);
  map.Read(YamlNode::ParseFile(file.string()));
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

#include "twin/scenario/lab.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/link_reader.h"
#include "scenario/section_readers.h"
#include "scenario/yaml_node.h"
#include "twin/core/error.h"

namespace twin::scenario {
namespace {

constexpr std::array<std::string_view, 4> kKeys{"description", "plant", "link", "controller"};

/// Says of a scenario's section why a lab has none.
void RequireKeysOfALab(const YamlNode& root) {
  constexpr std::array<std::string_view, 17> kScenarios{
      "name",  "seed",    "backend", "drive",  "loop",        "scene",
      "robot", "onboard", "tick",    "motion", "application", "perturbations",
      "panel", "hand",    "render",  "record", "objects"};
  for (const auto& [key, value] : root.Entries()) {
    if (std::ranges::find(kScenarios, key) == kScenarios.end()) continue;
    value.Fail(fmt::format("a lab says nothing of it: it is the scenario's; a lab has {}",
                           fmt::join(kKeys, ", ")));
  }
}

void ReadWorkstation(const YamlNode& node, ControllerSection& controller) {
  const YamlMap map = node.Map({"wake_delay", "cost"});
  IfGiven(map, "wake_delay", [&](const YamlNode& n) { controller.wake_delay = ReadDelay(n); });
  IfGiven(map, "cost", [&](const YamlNode& n) { controller.cost = ReadDelay(n); });
}

std::vector<std::string> NamesIn(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace

std::filesystem::path FindLab(std::string_view lab, const std::filesystem::path& models) {
  const std::filesystem::path folder = models / "labs";
  const bool is_path = lab.find('/') != std::string_view::npos || lab.ends_with(".yaml");
  std::filesystem::path file =
      is_path ? std::filesystem::path(lab) : folder / (std::string(lab) + ".yaml");
  std::error_code error;
  if (std::filesystem::is_regular_file(file, error)) return file;
  throw InputError(fmt::format("--lab \"{}\": there is no file {}; give a file, or one of {}", lab,
                               file.string(), fmt::join(NamesIn(folder), ", ")));
}

void ApplyLab(const std::filesystem::path& file, Scenario& scenario) {
  const YamlNode root = YamlNode::ParseFile(file.string());
  RequireKeysOfALab(root);
  const YamlMap map = root.Map({"description", "plant", "link", "controller"});
  IfGiven(map, "description", [](const YamlNode& n) { (void)n.Text(); });
  IfGiven(map, "plant", [&](const YamlNode& n) { ReadPlant(n, scenario.plant); });
  IfGiven(map, "link", [&](const YamlNode& n) { ReadLink(n, scenario.link); });
  IfGiven(map, "controller", [&](const YamlNode& n) { ReadWorkstation(n, scenario.controller); });
  try {
    scenario.Validate();
  } catch (const InputError& error) {
    root.Fail(fmt::format("with scenario {}: {}", scenario.name, error.what()));
  }
}

}  // namespace twin::scenario

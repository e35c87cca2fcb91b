#include "twin/scenario/scenario.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenario/sections.h"
#include "twin/core/error.h"

namespace twin::scenario {
namespace {

/// Adds the keys of a lab.
void DescribeLab(Map& map, Scenario& scenario, std::string& description, model::LabLimits& limits) {
  map.Add("description", Text(description), "For people.");
  map.Add("plant", SectionOf(scenario.plant), "As in scenarios.");
  map.Add("link", SectionOf(scenario.link), "As in scenarios.");
  map.Add("load", LoadOf(scenario.robot.load), "What hangs on the flange: robot.load.");
  const auto workstation = [&controller = scenario.controller](Map& of) {
    of.Add("wake_delay", DelayOf(controller.wake_delay), "As in scenarios.");
    of.Add("cost", DelayOf(controller.cost), "As in scenarios.");
  };
  map.Add("controller", Section(workstation), "How fast the site's workstation is.");
  map.Add("limits", LimitsOf(limits), "As in scenarios; added to the scenario's.");
}

/// Says of a scenario's section why a lab has none.
void RequireKeysOfALab(const YamlNode& root, const Map& lab) {
  Scenario any;
  Map scenarios;
  Describe(scenarios, any);
  const auto has = [](const Map& map, const std::string& key) {
    const std::vector<std::string_view> keys = map.Keys();
    return std::ranges::find(keys, key) != keys.end();
  };
  for (const auto& [key, value] : root.Entries()) {
    if (has(lab, key) || !has(scenarios, key)) continue;
    value.Fail(fmt::format("a lab says nothing of it: it is the scenario's; a lab has {}",
                           fmt::join(lab.Keys(), ", ")));
  }
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
  std::string description;
  model::LabLimits limits;
  Map map;
  DescribeLab(map, scenario, description, limits);
  RequireKeysOfALab(root, map);
  map.Read(root);
  const auto add_and_validate = [&] {
    scenario.limits.Add(limits);
    scenario.Validate();
  };
  root.Checked(add_and_validate, fmt::format("with scenario {}: ", scenario.name));
}

}  // namespace twin::scenario

#include "campaign/scenario_world.h"

#include <cstdio>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "campaign/shrink.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"

namespace twin::campaign {
namespace {

using scenario::Cell;
using scenario::Scenario;

/// A scenario of as many robots, one or several.
ScenarioWorld Parse(const std::string& text, const ScenarioWorld& alike) {
  static constexpr auto kFile = "shrunk.yaml";
  if (std::holds_alternative<Cell>(alike)) return scenario::ParseCell(text, kFile);
  return scenario::Parse(text, kFile);
}

ScenarioWorld Load(const std::filesystem::path& path) {
  ScenarioWorld world;
  if (scenario::HasRobots(path)) {
    world = scenario::LoadCell(path);
  } else {
    world = scenario::Load(path);
  }
  const Scenario& common = CommonOf(world);
  if (common.is_remote()) {
    throw InputError(
        fmt::format("{}: backend: {}: the campaign runs emulated robots; leave the backend out",
                    path.string(), common.backend));
  }
  if (!common.is_lockstep()) {
    throw InputError(
        fmt::format("{}: drive: {}: the campaign runs in lockstep; leave the drive out",
                    path.string(), common.drive_name()));
  }
  return world;
}

}  // namespace

scenario::Scenario& CommonOf(ScenarioWorld& world) {
  Cell* cell = std::get_if<Cell>(&world);
  return cell != nullptr ? cell->common : std::get<Scenario>(world);
}

std::string TextOf(const ScenarioWorld& world) {
  return std::visit([](const auto& it) { return scenario::ToYaml(it); }, world);
}

Shrunk ShrinkScenario(const ScenarioWorld& world, std::string_view invariant,
                      const RunScenario& run) {
  Shrunk shrunk;
  std::string whole;  // the smallest so far, with what it leaves out
  const auto fails = [&](const std::string& less) {
    try {
      ScenarioWorld smaller = Parse(less, world);
      std::string text = TextOf(smaller);
      if (text == whole) return true;
      const Outcome outcome = run(smaller, CommonOf(smaller).name + ", while it is shrunk,");
      if (!outcome.finding || outcome.finding->invariant != invariant) return false;
      shrunk.finding = outcome.finding;
      whole = std::move(text);
      return true;
    } catch (const InputError&) {
      return false;
    }
  };
  shrunk.text = TextOf(world);
  if (fails(shrunk.text)) shrunk.text = Shrink(shrunk.text, fails);
  return shrunk;
}

void Tell(const std::string& world, const Finding& finding) {
  fmt::print("{} violates the invariant {}: {}\n", world, finding.invariant, finding.text);
  std::fflush(stdout);
}

FileCounts CheckFiles(std::span<const std::filesystem::path> paths, const RunScenario& run) {
  std::vector<ScenarioWorld> worlds;
  for (const std::filesystem::path& path : paths) worlds.push_back(Load(path));
  FileCounts counts;
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const std::string name = paths[i].string();
    const Outcome outcome = run(worlds[i], name);
    if (outcome.finding) {
      ++counts.violating;
      Tell(name, *outcome.finding);
    } else if (!outcome.refusal.empty()) {
      ++counts.refused;
      fmt::print("{} is refused: {}\n", name, outcome.refusal);
    } else {
      fmt::print("{} violates no invariant: {}{}{}; states hash {}\n", name, outcome.end,
                 outcome.failure.empty() ? "" : ": ", outcome.failure,
                 FormatHash(outcome.states_hash));
    }
    std::fflush(stdout);
  }
  return counts;
}

}  // namespace twin::campaign

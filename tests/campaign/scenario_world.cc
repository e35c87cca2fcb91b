#include "campaign/scenario_world.h"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "campaign/cell_world.h"
#include "campaign/shrink.h"
#include "twin/core/error.h"

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
  if (scenario::HasRobots(path)) return scenario::LoadCell(path);
  return scenario::Load(path);
}

}  // namespace

scenario::Scenario& CommonOf(ScenarioWorld& world) {
  Cell* cell = std::get_if<Cell>(&world);
  return cell != nullptr ? cell->common : std::get<Scenario>(world);
}

std::string TextOf(const ScenarioWorld& world) {
  return std::visit([](const auto& it) { return scenario::ToYaml(it); }, world);
}

Outcome RunScenario(const ScenarioWorld& world, const run::Catalogue& catalogue,
                    const run::RunFiles& files, bool repeats) {
  const Cell* cell = std::get_if<Cell>(&world);
  return cell != nullptr ? RunCell(*cell, catalogue, files, repeats)
                         : RunWorld(std::get<Scenario>(world), catalogue, files, repeats);
}

Shrunk ShrinkScenario(const ScenarioWorld& world, const Finding& finding,
                      const run::Catalogue& catalogue, const run::RunFiles& files) {
  Shrunk shrunk;
  std::string whole;  // the smallest so far, with what it leaves out
  const auto fails = [&](const std::string& less) {
    try {
      const ScenarioWorld smaller = Parse(less, world);
      std::string text = TextOf(smaller);
      if (text == whole) return true;
      const Outcome outcome =
          RunScenario(smaller, catalogue, files, NeedsRepeats(finding.invariant));
      if (!outcome.finding || outcome.finding->invariant != finding.invariant) return false;
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

bool CheckFiles(std::span<const std::filesystem::path> paths, const run::Catalogue& catalogue,
                const run::RunFiles& files) {
  bool is_clean = true;
  for (const std::filesystem::path& path : paths) {
    ScenarioWorld world = Load(path);
    if (const Scenario& common = CommonOf(world); !common.is_lockstep()) {
      throw InputError(
          fmt::format("{}: the drive is {}; what the campaign checks runs in lockstep: choose that",
                      path.string(), common.drive_name()));
    }
    const Outcome outcome = RunScenario(world, catalogue, files, true);
    if (!outcome.refusal.empty()) {
      throw InputError(fmt::format("{}: {}", path.string(), outcome.refusal));
    }
    if (outcome.finding) {
      is_clean = false;
      fmt::print("{} violates the invariant {}: {}\n", path.string(), outcome.finding->invariant,
                 outcome.finding->text);
    } else {
      fmt::print("{} violates no invariant; {} cycles, {}\n", path.string(), outcome.cycles,
                 outcome.end);
    }
    std::fflush(stdout);
  }
  return is_clean;
}

}  // namespace twin::campaign

#include "campaign/cell_world.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "campaign/application_world.h"
#include "campaign/world.h"
#include "conformance/dice.h"
#include "twin/application/partners.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"
#include "twin/plant/shared_model.h"
#include "twin/rt/fiber.h"
#include "twin/run/islands.h"

namespace twin::campaign {
namespace {

using scenario::Cell;
using scenario::CellRobot;
using scenario::Scenario;

/// Bases so far apart, m, are of arms that do not meet: only stretched out would they.
constexpr double kApart = 2.1;
constexpr double kSame = 1e-6;             // rad
constexpr double kSameAfterImpact = 1e-4;  // rad, since an impact lets last digits grow

/// One robot of a cell. @param seed  of a world.
Scenario DrawRobot(std::uint64_t seed) {
  Scenario world = DrawWorld(seed);
  world.plant.kind = robot::PlantKind::kMujoco;
  world.plant.base_tilt = {};
  world.base.reset();
  world.objects.clear();
  return world;
}

bool MayTouch(const Cell& cell) {
  const auto is_near = [](const CellRobot& one, const CellRobot& other) {
    const Vector3& a = one.scenario.robot.pose.position;
    const Vector3& b = other.scenario.robot.pose.position;
    return &one != &other && std::hypot(a[0] - b[0], a[1] - b[1]) < kApart;
  };
  return std::ranges::any_of(cell.robots, [&](const CellRobot& one) {
    return std::ranges::any_of(cell.robots, std::bind_front(is_near, std::cref(one)));
  });
}

/// What came of each robot, in their order.
using RobotOutcomes = std::vector<std::pair<std::string, Outcome>>;

void RunIsland(const run::Island& island, const run::Catalogue& catalogue,
               const run::RunFiles& files, bool may_touch, RobotOutcomes& outcomes) {
  application::MessageBoard board(island.robots);
  const auto run = [&](std::size_t i, const backend::Registry& backends, Outcome& outcome) {
    run::RunFiles own = files;
    own.neighbours = {island.robots, i};
    const application::Partners partners(board, i);
    outcome =
        RunOnce(island.robots[i].scenario, {backends, catalogue.controllers, catalogue.devices},
                own, may_touch, &partners);
    board.End(i, outcome.failure);
  };
  std::deque<Outcome> ends(island.robots.size());
  if (ends.size() == 1) {
    run(0, catalogue.backends, ends.front());
  } else {
    const auto shared =
        plant::SharedModel::Create(run::PlantsOf(island.robots, files), [] { rt::Fiber::Yield(); });
    std::deque<backend::Registry> seats;
    std::deque<rt::Fiber> runs;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const CellRobot& robot = island.robots[i];
      seats.push_back(run::SeatOf(robot, shared, catalogue.backends));
      runs.emplace_back([&, i] {
        run(i, seats[i], ends[i]);
        shared->Forgo(run::PrefixOf(island.robots[i]));
      });
    }
    rt::ResumeInTurn(runs);
  }
  for (std::size_t i = 0; i < ends.size(); ++i) {
    outcomes.emplace_back(island.robots[i].name, std::move(ends[i]));
  }
}

RobotOutcomes RunRobots(const Cell& cell, const run::Catalogue& catalogue,
                        const run::RunFiles& files) {
  run::RequireApartAtStart(cell, files);
  RobotOutcomes outcomes;
  for (const run::Island& island : run::IslandsOf(cell, files)) {
    RunIsland(island, catalogue, files, MayTouch(cell), outcomes);
  }
  return outcomes;
}

std::optional<Finding> CompareAgain(const RobotOutcomes& first, const RobotOutcomes& again) {
  for (std::size_t i = 0; i < again.size(); ++i) {
    const std::uint64_t here = first[i].second.states_hash;
    const std::uint64_t there = again[i].second.states_hash;
    if (here == there) continue;
    return Finding{"repeats", fmt::format("{}: states {}, again {}", first[i].first,
                                          FormatHash(here), FormatHash(there))};
  }
  return std::nullopt;
}

/// A model of several arms rounds otherwise.
std::optional<Finding> CompareAlone(const std::string& name, const Outcome& here,
                                    const Outcome& alone) {
  double off = 0;
  const std::size_t cycles = std::min(here.path.size(), alone.path.size());
  for (std::size_t k = 0; k < cycles; ++k) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      off = std::max(off, std::abs(here.path[k][i] - alone.path[k][i]));
    }
  }
  const bool meets_itself = here.end.find("self_collision") != std::string::npos;
  if (off <= (meets_itself ? kSameAfterImpact : kSame) && here.end == alone.end &&
      here.cycles == alone.cycles)
    return std::nullopt;
  return Finding{"alone",
                 fmt::format("{}: {} after {} cycles; alone {} after {}, and it was up to {} "
                             "rad elsewhere",
                             name, here.end, here.cycles, alone.end, alone.cycles, off)};
}

std::optional<Finding> Repeat(const Cell& cell, const RobotOutcomes& first,
                              const run::Catalogue& catalogue, const run::RunFiles& files) {
  auto finding = CompareAgain(first, RunRobots(cell, catalogue, files));
  if (MayTouch(cell)) return finding;
  for (const auto& [name, outcome] : first) {
    if (finding) return finding;
    const Scenario& robot = std::ranges::find(cell.robots, name, &CellRobot::name)->scenario;
    // Without its rotors' inertia an arm may swing, and a last digit then grows.
    if (!robot.plant.armature) continue;
    const Outcome alone = RunOnce(robot, catalogue, files);
    finding = alone.finding ? alone.finding : CompareAlone(name, outcome, alone);
  }
  return finding;
}

Outcome Sum(const RobotOutcomes& outcomes) {
  Outcome sum;
  WordHash hash;
  for (const auto& [name, outcome] : outcomes) {
    if (outcome.finding && !sum.finding) {
      sum.finding =
          Finding{outcome.finding->invariant, fmt::format("{}: {}", name, outcome.finding->text)};
    }
    if (sum.refusal.empty() && !outcome.refusal.empty()) {
      sum.refusal = fmt::format("{}: {}", name, outcome.refusal);
    }
    if (sum.failure.empty()) sum.failure = outcome.failure;
    sum.cycles += outcome.cycles;
    hash.AddWord(outcome.states_hash);
  }
  sum.end = fmt::format("of {} robots{}", outcomes.size(),
                        sum.failure.empty() ? "" : ", failure of a task");
  sum.states_hash = hash.value();
  return sum;
}

/// The robots that hand a beam over, with links and clocks of their own.
Cell DrawHandOver(std::uint64_t seed, const std::filesystem::path& models) {
  Cell cell = scenario::LoadCell(models / "cells/hand_over.yaml");
  cell.common.name = fmt::format("world_{}", seed);
  cell.common.seed = seed;
  cell.common.render.enabled = false;
  std::uint64_t own_seed = (std::uint64_t{1} << 40) + 4 * seed;
  for (CellRobot& robot : cell.robots) {
    robot.scenario = DrawAround(own_seed++, std::move(robot.scenario));
    robot.scenario.robot.clock_drift_ppm =
        cell.robots.front().scenario.robot.clock_drift_ppm;  // they share a model
  }
  return cell;
}

}  // namespace

bool IsCellWorld(std::uint64_t seed) {
  return seed % 64 == 56;
}

Cell DrawCellWorld(std::uint64_t seed, const std::filesystem::path& models) {
  if (seed % 512 == 120) return DrawHandOver(seed, models);
  test::Dice dice(~seed);
  Cell cell;
  cell.common.name = fmt::format("world_{}", seed);
  cell.common.description = fmt::format("World {} of the reliability campaign.", seed);
  cell.common.seed = seed;
  cell.common.scene = "scenes/floor.xml";
  cell.common.render.enabled = false;
  const bool is_close = dice.Chance(0.5);
  double angle = dice.Between(-std::numbers::pi, std::numbers::pi);
  const int robots = dice.Whole(2, 3);
  for (int i = 0; i < robots; ++i) {
    // Of a world that no campaign comes to.
    const std::uint64_t own_seed = (std::uint64_t{1} << 40) + 4 * seed + static_cast<unsigned>(i);
    CellRobot robot{fmt::format("r{}", i), DrawRobot(own_seed), {}};
    Scenario& own = robot.scenario;
    own.robot.pose.yaw = dice.Between(-std::numbers::pi, std::numbers::pi);
    if (i > 0) {
      const double away = is_close ? dice.Between(0.6, 1.4) : dice.Between(kApart, 2.3);
      own.robot.pose.position = {away * std::cos(angle), away * std::sin(angle), 0};
      own.robot.clock_drift_ppm = cell.robots.front().scenario.robot.clock_drift_ppm;
      angle += dice.Between(1.3, 2);
    }
    cell.robots.push_back(std::move(robot));
  }
  return cell;
}

Outcome RunCell(const Cell& cell, const run::Catalogue& catalogue, const run::RunFiles& files,
                bool repeats) {
  try {
    const std::string text = scenario::ToYaml(cell);
    const Cell read = scenario::ParseCell(text, cell.common.name + ".yaml");
    const RobotOutcomes outcomes = RunRobots(read, catalogue, files);
    Outcome sum = Sum(outcomes);
    if (scenario::ToYaml(read) != text) {
      sum.finding = Finding{"repeats", "its text, read back, is another cell"};
    }
    if (!sum.finding && repeats) sum.finding = Repeat(read, outcomes, catalogue, files);
    return sum;
  } catch (const InputError& error) {
    Outcome refused;
    refused.refusal = error.what();
    return refused;
  }
}

}  // namespace twin::campaign

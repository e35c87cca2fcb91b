#include "campaign/application_world.h"

#include <array>
#include <string>
#include <utility>

#include "campaign/world.h"
#include "conformance/dice.h"
#include "twin/run/operator_page.h"

namespace twin::campaign {
namespace {

/// Whether people at an operator's page lead the robot.
bool IsPageWorld(std::uint64_t seed) {
  return seed % 256 == 104;
}

scenario::Scenario DrawPageWorld(std::uint64_t seed, const std::filesystem::path& models) {
  scenario::Scenario world = scenario::Load(models / "applications" / "teleoperation.yaml");
  world.operator_section->device = run::kPageDevice;
  world.application->parameters.push_back({.key = "longest", .values = {"60 s"}});
  test::Dice dice(seed);
  if (dice.Chance(0.5)) world.base.reset();
  world = DrawAround(seed, std::move(world));
  world.perturbations.clear();  // they would move an arm that must stand
  return world;
}

}  // namespace

bool IsApplicationWorld(std::uint64_t seed) {
  return seed % 256 == 40 || IsPageWorld(seed);
}

scenario::Scenario DrawApplicationWorld(std::uint64_t seed, const std::filesystem::path& models) {
  static constexpr std::array kApplications{"compliance",         "pick_and_place",
                                            "pick_and_place_can", "pick_and_place_tilted",
                                            "plan_and_execute",   "teleoperation"};
  if (IsPageWorld(seed)) return DrawPageWorld(seed, models);
  test::Dice dice(~seed);
  const auto which = static_cast<std::size_t>(dice.Whole(0, kApplications.size() - 1));
  return DrawAround(seed, scenario::Load(models / "applications" /
                                         (std::string(kApplications[which]) + ".yaml")));
}

scenario::Scenario DrawAround(std::uint64_t seed, scenario::Scenario world) {
  test::Dice dice(~seed);
  scenario::Scenario drawn = DrawWorld(seed, &world);
  world.name = drawn.name;
  world.seed = seed;
  world.drive = drawn.drive;
  world.render.enabled = false;
  // What the arm holds and works on stays.
  if (dice.Chance(0.7)) world.link = drawn.link;
  if (dice.Chance(0.2) && world.perturbations.empty()) world.perturbations = drawn.perturbations;
  world.robot.clock_drift_ppm = drawn.robot.clock_drift_ppm;
  world.tick.cost = drawn.tick.cost;
  world.controller.clock_drift_ppm = drawn.controller.clock_drift_ppm;
  world.controller.phase = drawn.controller.phase;
  world.controller.wake_delay = drawn.controller.wake_delay;
  world.controller.cost = drawn.controller.cost;
  return world;
}

}  // namespace twin::campaign

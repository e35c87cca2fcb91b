#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "campaign/scenario_world.h"

namespace twin::campaign::campaign_scenario_world_test {
namespace {

using scenario::Scenario;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr auto kWorld = R"(name: world_7
seed: 7
tick: {period_tolerance: 400 us}
link: {command_loss: 3 %, d_INT: 200 us}
motion: {trajectory: {unit: rad, waypoints: [{q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}, {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}]}}
)";

/// Violates `viability` where a period's tolerance and losses meet, and else, with another seed,
/// `finite`.
Outcome Run(const Scenario& world) {
  Outcome outcome;
  if (world.seed != 7) outcome.finding = {"finite", "other"};
  if (world.tick.period_tolerance != Duration::zero() &&
      world.link.command.loss != decltype(world.link.command.loss){}) {
    outcome.finding = {"viability", "of " + std::to_string(world.seed)};
  }
  return outcome;
}

Shrunk ShrunkFor(std::string_view invariant, int& runs) {
  return ShrinkScenario(scenario::Parse(kWorld, "world_7.yaml"), invariant,
                        [&](const ScenarioWorld& world, const std::string& name) {
                          ++runs;
                          EXPECT_EQ(name, "world_7, while it is shrunk,");
                          return Run(std::get<Scenario>(world));
                        });
}

TEST(ShrinkScenario, LeavesTheKeysThatViolateTheSameInvariant) {
  int runs = 0;
  const Shrunk shrunk = ShrunkFor("viability", runs);
  EXPECT_THAT(shrunk.text, HasSubstr("period_tolerance: 400 us"));
  EXPECT_THAT(shrunk.text, HasSubstr("command_loss: 3 %"));
  EXPECT_THAT(shrunk.text, Not(HasSubstr("d_INT")));
  EXPECT_THAT(shrunk.text, Not(HasSubstr("seed:")));
  EXPECT_THAT(shrunk.text, Not(HasSubstr("render")));
  EXPECT_NE(shrunk.finding, std::nullopt);
  EXPECT_LT(runs, 20) << "what leaves a scenario as it is needs no run";
}

TEST(ShrinkScenario, LeavesAWorldThatViolatesNothingAsItIs) {
  int runs = 0;
  const Shrunk shrunk = ShrunkFor("energy", runs);
  EXPECT_EQ(shrunk.finding, std::nullopt);
  EXPECT_THAT(shrunk.text, HasSubstr("seed: 7"));
  EXPECT_EQ(runs, 1);
}

}  // namespace
}  // namespace twin::campaign::campaign_scenario_world_test

// What pick and place bears: a hundred drawn tasks; with lost messages, at both labs, of other
// shapes.
#include <string>

#include <gtest/gtest.h>

#include "application/monte_carlo.h"
#include "application/performance.h"
#include "application/seeds.h"
#include "twin/scenario/scenario.h"

namespace twin::application::application_pick_seeds_test {
namespace {

using test::Draw;

scenario::Scenario Shipped(const std::string& lab = "",
                           const std::string& name = "pick_and_place") {
  scenario::Scenario scenario = scenario::Load(test::FileOf(name));
  if (!lab.empty()) ApplyLab(scenario::FindLab(lab, test::Models()), scenario);
  return scenario;
}

TEST(PickSeedsTest, NearlyAllDrawnTasksSucceed) {
  EXPECT_GE(Draw(Shipped(), "shipped").succeeded, 98);
}

TEST(PickSeedsTest, NearlyAsManyWhenOneMessageInAHundredIsLost) {
  scenario::Scenario scenario = Shipped();
  scenario.link.state.loss.law = scenario::IndependentLoss{1};
  scenario.link.command.loss.law = scenario::IndependentLoss{1};
  EXPECT_GE(Draw(scenario, "1 % lost each way").succeeded, 95);
}

TEST(PickSeedsTest, AtBothLabsToo) {
  EXPECT_GE(Draw(Shipped("a"), "lab a").succeeded, 98);
  EXPECT_GE(Draw(Shipped("b"), "lab b").succeeded, 98);
}

TEST(PickSeedsTest, InEveryVariant) {
  for (const char* name :
       {"pick_and_place_can", "pick_and_place_tilted", "pick_and_place_upright"}) {
    EXPECT_GE(Draw(Shipped("", name), name, 40).succeeded, 39) << name;
  }
}

}  // namespace
}  // namespace twin::application::application_pick_seeds_test

#include "application/monte_carlo.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "application/performance.h"
#include "application/seeds.h"
#include "twin/core/error.h"

namespace twin::application::application_monte_carlo_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(MonteCarloTest, CarriesOutSeedBySeedWhateverTheThreads) {
  scenario::Scenario scenario = scenario::Load(test::FileOf("pick_and_place"));
  scenario.seed = 3;
  const MonteCarloResult one = test::Seeds(scenario, {.seeds = 3, .threads = 1});
  std::vector<std::uint64_t> told;
  const MonteCarloResult two =
      test::Seeds(scenario, {.seeds = 3, .threads = 2},
                  [&told](const SeedOutcome& outcome) { told.push_back(outcome.seed); });
  ASSERT_EQ(one.outcomes.size(), 3U);
  ASSERT_EQ(two.outcomes.size(), 3U);
  EXPECT_THAT(told, testing::UnorderedElementsAre(3, 4, 5));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(one.outcomes[i].seed, 3 + i);
    EXPECT_TRUE(one.outcomes[i].succeeded()) << one.outcomes[i].failure;
    EXPECT_EQ(one.outcomes[i].states_hash, two.outcomes[i].states_hash);
  }
  EXPECT_NE(one.outcomes[0].states_hash, one.outcomes[1].states_hash) << "other seeds, other tasks";
  EXPECT_EQ(one.succeeded, 3);
  EXPECT_EQ(one.share(), 1);
  EXPECT_LT(one.least_share, 0.5) << "three runs say little";
  const std::vector<FindingSpread> spreads = one.Spreads();
  ASSERT_FALSE(spreads.empty());
  EXPECT_EQ(spreads[0].quantity, one.outcomes[0].findings[0].quantity);
}

TEST(MonteCarloTest, CountsFailuresAndNamesTheStep) {
  scenario::Scenario scenario = scenario::Load(test::FileOf("pick_and_place"));
  scenario.objects[1].pose.position = {1.2, 0.3, 0};  // out of reach
  const MonteCarloResult result = test::Seeds(scenario, {.seeds = 2, .threads = 2});
  EXPECT_EQ(result.succeeded, 0);
  ASSERT_EQ(result.outcomes.size(), 2U);
  for (const SeedOutcome& outcome : result.outcomes) {
    EXPECT_EQ(outcome.failed_step, "plan");
    EXPECT_THAT(outcome.failure, HasSubstr("step plan failed"));
    EXPECT_THAT(outcome.failure, HasSubstr("transfer"));
  }
}

TEST(MonteCarloTest, TakesLockstepAndSomeSeeds) {
  scenario::Scenario scenario = scenario::Load(test::FileOf("pick_and_place"));
  EXPECT_THAT([&] { (void)test::Seeds(scenario, {.seeds = 0}); },
              ThrowsMessage<InputError>(HasSubstr("seeds")));
  scenario.drive = scenario::Drive::kRealtime;
  EXPECT_THAT([&] { (void)test::Seeds(scenario, {.seeds = 1}); },
              ThrowsMessage<InputError>(HasSubstr("lockstep")));
}

}  // namespace
}  // namespace twin::application::application_monte_carlo_test

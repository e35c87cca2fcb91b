// What a user gets who says nothing of `tick:`: an arm that stays with its plan whatever of 1 to 19
// commands in a row is lost, and behind a source that wakes late.
#include <chrono>

#include <gtest/gtest.h>

#include "run/chain_runs.h"

namespace twin::run::test::chain_runs::run_default_chain_test {
namespace {

/// Most that bursts may add to the deviation of the run without losses: 2 mrad, or 2 mm.
constexpr double kAdded = 2e-3;

class DefaultChainTest : public ::testing::TestWithParam<std::tuple<CommandInterface, Tempo>> {
 protected:
  const Bench bench_;
};

TEST_P(DefaultChainTest, StaysWithItsPlanThroughBurstsOfAnyLengthTheRobotBears) {
  const auto [interface, tempo] = GetParam();
  scenario::Scenario scenario = bench_.Make(interface, tempo);
  const Outcome without = bench_.Run(scenario);
  ASSERT_FALSE(without.aborted()) << without.result.report.failure;
  for (std::uint64_t length = 1; length <= 19; ++length) {
    scenario.link.command.loss = BurstsOf(length);
    const Outcome with = bench_.Run(scenario);
    EXPECT_FALSE(with.aborted()) << "bursts of " << length << ": " << with.result.report.failure;
    EXPECT_LE(with.deviation, without.deviation + kAdded) << "bursts of " << length;
  }
}

std::string NameOf(const ::testing::TestParamInfo<DefaultChainTest::ParamType>& info) {
  const auto interface = std::get<0>(info.param);
  const char* name = interface == CommandInterface::kJointPosition   ? "positions_"
                     : interface == CommandInterface::kJointVelocity ? "velocities_"
                     : interface == CommandInterface::kTorque        ? "torques_"
                                                                     : "poses_";
  return name + std::string(std::get<1>(info.param).name);
}

// At the hard tempo the torques of the plan alone are more than the robot has.
INSTANTIATE_TEST_SUITE_P(Torques, DefaultChainTest,
                         ::testing::Combine(::testing::Values(CommandInterface::kTorque),
                                            ::testing::Values(kGentle, kBrisk)),
                         NameOf);

INSTANTIATE_TEST_SUITE_P(Motions, DefaultChainTest,
                         ::testing::Combine(::testing::Values(CommandInterface::kJointPosition,
                                                              CommandInterface::kJointVelocity,
                                                              CommandInterface::kCartesianPose),
                                            ::testing::Values(kGentle, kBrisk, kHard)),
                         NameOf);

TEST(DefaultChainUnderLateWakesTest, FollowsCanonicalWithin10Milliradians) {
  const Bench bench;
  scenario::Scenario scenario = bench.Canonical();
  scenario.controller.wake_delay = LateWakes(0.3, std::chrono::milliseconds(12));
  for (scenario.seed = 1; scenario.seed <= 5; ++scenario.seed) {
    const Outcome outcome = bench.Run(scenario);
    EXPECT_FALSE(outcome.aborted()) << outcome.result.report.failure;
    EXPECT_LE(outcome.deviation, 10e-3);
  }
}

// Noise of 10 urad demands six times the jerk limit in each cycle. The correction, whose
// differences carried it, led the arm up to 1.5 rad off its path while the viability filter kept
// most commands back.
TEST(DefaultChainOfANoisySourceTest, FollowsWithin10MilliradiansAndEnds) {
  const Bench bench;
  for (const CommandInterface interface :
       {CommandInterface::kJointPosition, CommandInterface::kCartesianPose}) {
    for (const double noise : {1e-6, 3e-6, 1e-5, 1e-4}) {
      scenario::Scenario scenario = bench.Make(interface, kGentle);
      scenario.controller.target_noise = noise;
      const Outcome outcome = bench.Run(scenario);
      SCOPED_TRACE(testing::Message()
                   << (interface == CommandInterface::kCartesianPose ? "poses" : "positions")
                   << ", noise " << noise);
      EXPECT_FALSE(outcome.aborted()) << outcome.result.report.failure;
      EXPECT_LE(outcome.deviation, 10e-3);
    }
  }
}

}  // namespace
}  // namespace twin::run::test::chain_runs::run_default_chain_test

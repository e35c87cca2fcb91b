// Led motion is harmless, whatever the operator does: some random operators.
#include <gtest/gtest.h>

#include "application/random_operators.h"

namespace twin::application::application_random_operators_test {
namespace {

TEST(RandomOperatorsTest, DoNotMakeTheRobotStopOrReachAnEndStop) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const test::Led led = test::LetLead(seed, std::chrono::seconds(20));
    EXPECT_EQ(led.failure, "") << "operator " << seed;
    EXPECT_GT(led.margin, 0.01) << "operator " << seed;
  }
}

TEST(RandomOperatorsTest, PressOntoAMovableBoxAndPushItWithoutAReflex) {
  using std::chrono::seconds;
  constexpr double kSpeed = 0.6;  // the page's usual
  const std::vector<Vector6> pushes{{kSpeed}, {-kSpeed}, {0, kSpeed}, {0, 0, 0, 0, 0, kSpeed}};
  for (const Vector6& push : pushes) {
    const test::Led led = test::LetLead(test::AboveABox(1), [&](const teleop::DeviceRequest&) {
      return std::make_unique<test::PlannedOperator>(std::vector<test::PlannedOperator::Keys>{
          {{}, seconds(1)}, {{0, 0, -kSpeed}, seconds(8)}, {push, seconds(4)}});
    });
    EXPECT_EQ(led.failure, "") << push[0] << " " << push[1] << " " << push[5];
  }
}

TEST(RandomOperatorsTest, DoNotMakeTheRobotStopAboveAMovableBox) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const test::Led led = test::LetLead(test::AboveABox(seed), [&](const teleop::DeviceRequest&) {
      return std::make_unique<test::RandomOperator>(seed, test::Turns::kNoJoint, false,
                                                    std::chrono::seconds(20));
    });
    EXPECT_EQ(led.failure, "") << "operator " << seed;
  }
}

}  // namespace
}  // namespace twin::application::application_random_operators_test

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

}  // namespace
}  // namespace twin::application::application_random_operators_test

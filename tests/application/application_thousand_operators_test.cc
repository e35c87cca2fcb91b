// Led motion is harmless, whatever the operator does: 1000 random operators, a minute each.
#include <atomic>
#include <cstdio>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "application/random_operators.h"

namespace twin::application::application_thousand_operators_test {
namespace {

constexpr std::uint64_t kOperators = 1000;
constexpr unsigned kThreads = 2;

TEST(ThousandOperatorsTest, NoneMakesTheRobotStopOrReachAnEndStop) {
  std::vector<test::Led> all(kOperators);
  std::atomic<std::uint64_t> next = 0;
  {
    std::vector<std::jthread> threads;
    for (unsigned i = 0; i < kThreads; ++i) {
      threads.emplace_back([&] {
        for (std::uint64_t seed = next++; seed < kOperators; seed = next++) {
          all[seed] = test::LetLead(seed, std::chrono::seconds(60));
        }
      });
    }
  }
  double margin = all[0].margin;
  std::uint64_t failed = 0;
  for (std::uint64_t seed = 0; seed < kOperators; ++seed) {
    margin = std::min(margin, all[seed].margin);
    if (all[seed].failure.empty() && all[seed].margin > 0.01) continue;
    ++failed;
    std::printf("operator %d: margin %.3f rad: %s\n", static_cast<int>(seed), all[seed].margin,
                all[seed].failure.c_str());
  }
  std::printf("least margin of a joint: %.3f rad\n", margin);
  EXPECT_EQ(failed, 0);
}

}  // namespace
}  // namespace twin::application::application_thousand_operators_test

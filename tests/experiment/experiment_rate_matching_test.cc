#include "experiment/studies.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"
#include "experiment/wave_source.h"

namespace twin::experiment::experiment_rate_matching_test {
namespace {

using control::CommandInterface;

TEST(WaveSourceTest, VelocityIsThePositionsDerivativeAndRestsAtBothEnds) {
  constexpr double kStep = 1e-5;
  for (const double t : {0.3, 1.1, 2.9}) {
    const auto q = [](double at) { return WaveAt(CommandInterface::kJointPosition, 0.8, at); };
    const auto dq = [](double at) { return WaveAt(CommandInterface::kJointVelocity, 0.8, at); };
    EXPECT_NEAR((q(t + kStep).value - q(t - kStep).value) / (2 * kStep), dq(t).value, 1e-9);
    EXPECT_NEAR((dq(t + kStep).value - dq(t - kStep).value) / (2 * kStep), dq(t).rate, 1e-9);
  }
  EXPECT_NEAR(WaveAt(CommandInterface::kJointVelocity, 0.8, 3.9999999).value, 0, 1e-12);
}

TEST(WaveSourceTest, ItsLargestAccelerationIsTheGivenOne) {
  double most = 0;
  for (int ms = 0; ms <= 4000; ++ms) {
    most = std::max(most, std::abs(WaveAt(CommandInterface::kJointVelocity, 0.8, ms * 1e-3).rate));
  }
  EXPECT_NEAR(most, 0.8, 1e-5);
}

TEST(WaveSourceTest, TheDelayOfASignalIsFound) {
  for (const CommandInterface interface :
       {CommandInterface::kJointPosition, CommandInterface::kJointVelocity}) {
    std::vector<double> signal;
    signal.reserve(4000);
    for (int k = 0; k < 4000; ++k) {
      signal.push_back(3 + WaveAt(interface, 0.8, k * 1e-3 - 0.0035).value);
    }
    EXPECT_NEAR(WaveDelay(interface, 0.8, signal), 0.0035, 1e-7);
  }
}

TEST(RateMatchingTest, TheStageDelaysByHalfAWindowAtEveryRate) {
  const test::ExperimentBench bench;
  const Findings findings = RunRateMatching(bench.config(1));
  EXPECT_TRUE(findings.succeeded());
  ASSERT_EQ(findings.figures.size(), 3U);
  EXPECT_EQ(test::FiguresOnPage(findings, "rate_matching"), 3U);
  for (const std::vector<double>& row : findings.figures[1].rows) {
    ASSERT_EQ(row.size(), 6U);
    EXPECT_NEAR(row[2], (row[1] - 1) / 2, 1e-12);
    EXPECT_EQ(row[1], std::ceil(1000 / row[0]));
  }
}

}  // namespace
}  // namespace twin::experiment::experiment_rate_matching_test

#include "experiment/studies.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"
#include "experiment/tracking.h"

namespace twin::experiment::experiment_tracking_test {
namespace {

constexpr double kGain = 0.385870;  // of 100 Hz at 1 kHz

TEST(LowPassedResponseTest, FollowsSlowMotionWholeAndFastMotionByTheGain) {
  EXPECT_NEAR(std::abs(LowPassedResponse(kGain, 1e-3, 1e-4)), 1, 1e-3);
  EXPECT_NEAR(std::abs(LowPassedResponse(kGain, 1e-3, 100)), kGain, 1e-3);
}

TEST(LowPassedResponseTest, IsTheStationaryAnswerOfTheRecursionItStandsFor) {
  // q_d += g (T dq + lambda (q - q_d)), driven by dq = cos(w t): after 40 s only the sine is left.
  constexpr double kFrequencyHz = 0.25;
  constexpr double kLambda = 1e-3;
  const double omega = 2 * M_PI * kFrequencyHz;
  double q_d = 0;
  double most = 0;
  for (int k = 0; k < 60'000; ++k) {
    const double t = k * 1e-3;
    const double step =
        kGain * (1e-3 * std::cos(omega * t) + kLambda * (std::sin(omega * t) / omega - q_d));
    q_d += step;
    if (k > 40'000) most = std::max(most, std::abs(step) / 1e-3);
  }
  EXPECT_NEAR(most, std::abs(LowPassedResponse(kGain, kLambda, kFrequencyHz)), 2e-3);
}

TEST(FollowedShareTest, ItsErrorIsThatOfTheWorstFrequency) {
  FollowedShare share;
  share.expected.fill(0.5);
  share.measured.fill(0.5);
  share.measured[3] = {0.5, 0.05};
  EXPECT_NEAR(share.largest_error(), 0.1, 1e-12);
}

TEST(TrackingTest, TheSynchronousLoopsTimingShakesTheArm) {
  const test::ExperimentBench bench;
  const Findings findings = RunTracking(bench.config(1));
  ASSERT_GE(findings.comparisons.size(), 4U);
  EXPECT_GT(findings.comparisons[0].ours, 5);
  EXPECT_LT(findings.comparisons[3].ours, 3);
  EXPECT_TRUE(findings.succeeded());
  EXPECT_EQ(findings.figures.size(), 5U);
  EXPECT_EQ(test::FiguresOnPage(findings, "tracking"), 5U);
  for (const Figure& figure : findings.figures) {
    const auto columns = 1 + std::ranges::count(figure.columns, ',');
    ASSERT_FALSE(figure.rows.empty());
    EXPECT_EQ(figure.rows.back().size(), static_cast<std::size_t>(columns)) << figure.id;
  }
}

}  // namespace
}  // namespace twin::experiment::experiment_tracking_test

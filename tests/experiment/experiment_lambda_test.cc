#include "experiment/studies.h"

#include <cmath>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"
#include "experiment/viability.h"
#include "support/panda_limits.h"

namespace twin::experiment::experiment_lambda_test {
namespace {

TEST(ChainBenchTest, AnOffsetDecaysByLambdaACycle) {
  constexpr double kLambda = 5e-3;
  loop::TickConfig tick;
  tick.lambda = kLambda;
  ChainBench bench(tick, {});
  for (int k = 0; k < 400; ++k) bench.Step(1e-3, 0, true);
  EXPECT_NEAR((1e-3 - bench.q_d()) / 1e-3, std::pow(1 - kLambda, 400), 1e-9);
}

TEST(ChainBenchTest, ASourceInTimeIsFollowedWithItsVelocity) {
  ChainBench bench({}, {});
  for (int k = 1; k <= 12'000; ++k) bench.Step(0.2e-3 * k, 0.2, true);
  EXPECT_NEAR(bench.dq_d(), 0.2, 1e-7);
  EXPECT_NEAR(bench.jerk(), 0, 1e-3);
}

TEST(ChainBenchTest, ASourceThatStopsForEverIsDecayedTo) {
  loop::TickConfig tick;
  tick.limits = twin::test::PandaLimits();
  ChainBench bench(tick, {});
  double q = 0;
  for (int k = 1; k <= 1000; ++k) {
    q = 0.1e-3 * k;
    bench.Step(q, 0.1, true);
  }
  for (int k = 0; k < 12'000; ++k) bench.Step(q, 0.1, false);
  EXPECT_NEAR(bench.q_d(), q, 1e-5);
  EXPECT_NEAR(bench.dq_d(), 0, 1e-5);
}

TEST(LambdaTest, ConvergenceKeepsToItsFormulaForJointsAndPoses) {
  const test::ExperimentBench bench;
  const Findings findings = RunLambda(bench.short_config(1));
  ASSERT_GE(findings.comparisons.size(), 2U);
  EXPECT_LE(findings.comparisons[0].ours, 1) << "%, joints";
  EXPECT_LE(findings.comparisons[1].ours, 1) << "%, poses";
  for (const Comparison& comparison : findings.comparisons) {
    EXPECT_NE(comparison.verdict, Verdict::kNotReproduced) << comparison.quantity;
  }
  EXPECT_EQ(findings.figures.size(), 2U);
  EXPECT_EQ(test::FiguresOnPage(findings, "lambda"), 2U);
}

}  // namespace
}  // namespace twin::experiment::experiment_lambda_test

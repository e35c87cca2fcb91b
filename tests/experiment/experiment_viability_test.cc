#include "experiment/studies.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"
#include "experiment/runs.h"
#include "experiment/stream.h"
#include "experiment/viability.h"
#include "twin/core/time.h"
#include "twin/reference/viability_filter.h"

namespace twin::experiment::experiment_viability_test {
namespace {

constexpr double kT = kCycleSeconds;

class ViabilityStudyTest : public ::testing::Test {
 protected:
  [[nodiscard]] reference::AxisBounds FirstJoint() const {
    return reference::BoundsOf(robot_.limits, 0);
  }

  const test::ExperimentBench bench_;
  const scenario::RobotData robot_ = LoadStreamInputs(bench_.config()).robot;
};

// A jerk of J T = A/2 a cycle: full acceleration is held for n cycles, then half of it.
TEST_F(ViabilityStudyTest, SpeedAtFullAccelerationLeavesRoomForTwoRunsOfLosses) {
  const reference::AxisBounds bounds = FirstJoint();
  for (const int lost : {0, 3, 20}) {
    const reference::ViableAxis axis(bounds, lost, "joint 1");
    EXPECT_NEAR(HighestSpeed(axis, 0, axis.kept().ddq_max),
                bounds.dq_max - kT * bounds.ddq_max * (1.5 * lost + 0.5), 1e-5)
        << lost;
  }
}

TEST_F(ViabilityStudyTest, WithoutLossesTheWayToStopIsThatOfFullDeceleration) {
  const reference::AxisBounds bounds = FirstJoint();
  EXPECT_NEAR(StoppingDistance({bounds, 0, "joint 1"}),
              bounds.dq_max * bounds.dq_max / (2 * bounds.ddq_max), 1e-5);
}

TEST_F(ViabilityStudyTest, WithoutLossesAMotionIsAsFastAsItCanBe) {
  const reference::AxisBounds bounds = FirstJoint();
  constexpr double kDistance = 0.05;
  constexpr double kLeft = 1e-3;
  const double fastest =
      2 * std::sqrt(kDistance / bounds.ddq_max) - std::sqrt(2 * kLeft / bounds.ddq_max);
  EXPECT_NEAR(RestToRestTime(bounds, 0, kDistance), fastest, 3 * kT) << "the jerk takes some";
}

TEST_F(ViabilityStudyTest, LambdaTakesAnOffsetAwayAtItsRate) {
  const auto chains = ComparedChains(robot_);
  const Convergence slow = MeasureConvergence(chains[1].tick, MiddleOf(robot_.limits), 0.1, false);
  EXPECT_NEAR(slow.time_s, std::log(1e-3) / std::log1p(-1e-3) * kT, 2 * kT);
  EXPECT_GT(slow.share, 1) << "the first step";
}

TEST_F(ViabilityStudyTest, ALimitedStreamSwingsAboutItsSource) {
  const auto chains = ComparedChains(robot_);
  const Convergence limited =
      MeasureConvergence(chains[3].tick, MiddleOf(robot_.limits), 0.1, false);
  EXPECT_TRUE(std::isnan(limited.time_s));
  EXPECT_GT(limited.overshoot, 0.5);
}

TEST_F(ViabilityStudyTest, AHostileSourceBreaksTheLimitsOfOthers) {
  const auto chains = ComparedChains(robot_);
  for (std::size_t chain = 0; chain < chains.size(); ++chain) {
    const auto cycles = RunHostileSource(chains[chain].tick);
    const auto most = std::ranges::max(cycles, {}, &HostileCycle::share);
    const auto highest = std::ranges::max(cycles, {}, &HostileCycle::q_d);
    const bool keeps = most.share <= 1 + 1e-9 && highest.q_d <= robot_.limits.q_max[0];
    EXPECT_EQ(keeps, chain == 0) << chains[chain].name;
  }
}

TEST_F(ViabilityStudyTest, ALostCommandHoldsTheAcceleration) {
  ChainBench bench({}, {});
  bench.Step(0, 1, true);
  const double ddq_d = bench.ddq_d();
  bench.Step(0, 1, true, true);
  EXPECT_EQ(bench.ddq_d(), ddq_d);
  EXPECT_NEAR(bench.dq_d(), 2 * kT * ddq_d, 1e-12);
}

TEST_F(ViabilityStudyTest, BurstsComeAsOftenAsSaidAndDoNotOverlap) {
  constexpr double kSeconds = 2000;
  const scenario::Loss loss =
      LossOf(bench_.config(), {.length = 10, .per_second = 5}, FromSeconds(kSeconds), 0);
  const auto& bursts = std::get<scenario::ScriptedLoss>(loss.law).bursts;
  // 0.2 s in the mean from the end of one to the begin of the next.
  EXPECT_NEAR(static_cast<double>(bursts.size()), kSeconds / 0.21, 0.05 * kSeconds / 0.21);
  for (std::size_t i = 1; i < bursts.size(); ++i) {
    ASSERT_GE(bursts[i].at, bursts[i - 1].at + 10 * kCycle) << i;
  }
}

TEST_F(ViabilityStudyTest, MeetsWhatItDemandsAndDraws) {
  const Findings findings = RunViability(bench_.config(2));
  for (const Comparison& comparison : findings.comparisons) {
    EXPECT_FALSE(comparison.is_missed())
        << comparison.quantity << ": " << comparison.ours << ", " << comparison.demand;
  }
  EXPECT_EQ(findings.figures.size(), 6U);
  EXPECT_EQ(test::FiguresOnPage(findings, "viability"), 6U);
  for (const Figure& figure : findings.figures) EXPECT_FALSE(figure.rows.empty()) << figure.id;
}

}  // namespace
}  // namespace twin::experiment::experiment_viability_test

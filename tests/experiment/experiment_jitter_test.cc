#include "experiment/studies.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"
#include "experiment/stream.h"

namespace twin::experiment::experiment_jitter_test {
namespace {

using control::CommandInterface;
using test::ExperimentBench;

constexpr double kT = kCycleSeconds;

class JitterTest : public ::testing::Test {
 protected:
  /// Joint 1 for a second, with this peak of its speed in rad/s.
  [[nodiscard]] reference::Trajectory AtSpeed(double speed) const {
    return SecondOfMotion({speed / 1.875}, limits_);
  }

  const ExperimentBench bench_;
  const StreamInputs streams_ = LoadStreamInputs(bench_.config());
  const JointLimits& limits_ = streams_.robot.limits;
};

TEST_F(JitterTest, AStreamOnTheRobotsTimeIsReconstructedAsPlanned) {
  const reference::Trajectory plan = AtSpeed(1);
  const StreamResult result =
      RunStream(plan, limits_, StreamBehind(Remedy::kRobotTime, streams_.robot), true,
                [&](std::uint64_t k, const onboard::JointReference& next) {
                  const auto t = static_cast<std::int64_t>(k) * kCycle;
                  EXPECT_DOUBLE_EQ(next.q_d[0], plan.Sample(t).q[0]);
                });
  EXPECT_FALSE(result.aborted);
  EXPECT_LE(result.jerk[0], plan.peaks().jerk[0] + 1e-6);
}

TEST_F(JitterTest, SamplingErrorsHaveTheStreamsDeviationAndRepeat) {
  const Stream stream{.jitter_s = 4e-6, .seed = 3};
  double square = 0;
  constexpr std::uint64_t kCount = 10'000;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    square += std::pow(ToSeconds(SamplingError(stream, i)), 2);
    ASSERT_EQ(SamplingError(stream, i), SamplingError(stream, i));
  }
  EXPECT_NEAR(std::sqrt(square / kCount), 4e-6, 0.1e-6);
  EXPECT_EQ(SamplingError({.jitter_s = 0}, 7), Duration::zero());
}

TEST_F(JitterTest, ReconstructedJerkLiesOnTheFormulasOfBothInterfaces) {
  for (const auto interface :
       {CommandInterface::kJointPosition, CommandInterface::kJointVelocity}) {
    const JitterJerk jerk = JerkOfJitter(streams_.canonical, limits_, interface, 4e-6, 1);
    EXPECT_LT(jerk.residual, 0.01);
    EXPECT_NEAR(jerk.ratio, 1, 0.01);
  }
}

TEST_F(JitterTest, TheFormulaIsTheOneOfThirdDifferences) {
  // White samples of deviation s: RMS of the third difference is sqrt(20) s.
  const JitterJerk jerk =
      JerkOfJitter(AtSpeed(1), limits_, CommandInterface::kJointPosition, 4e-6, 1);
  double expected = 0;
  for (const double t : jerk.t) {
    const double dq = AtSpeed(1).Sample(FromSeconds(t - 1.5 * kT)).dq[0];
    expected += std::pow(dq * std::sqrt(20.0) * 4e-6 / std::pow(kT, 3), 2);
  }
  const auto& formula = jerk.formula[0];
  const double found = std::inner_product(formula.begin(), formula.end(), formula.begin(), 0.0);
  EXPECT_NEAR(std::sqrt(found / expected), 1, 0.1);
}

TEST_F(JitterTest, TheRawCanonicalStreamAbortsAndTheGeneratorsDoesNot) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const Remedy remedy : {Remedy::kNone, Remedy::kGenerator}) {
      Stream stream = StreamBehind(remedy, streams_.robot);
      stream.jitter_s = 4e-6;
      stream.clock_ppm = 50;
      stream.phase =
          PhaseOfOvertaking(streams_.canonical, 50, 0.1 + 0.2 * static_cast<double>(seed));
      stream.seed = seed;
      const StreamResult result = RunStream(streams_.canonical, limits_, stream, true);
      EXPECT_EQ(result.aborted.has_value(), remedy == Remedy::kNone) << "seed " << seed;
    }
  }
}

TEST_F(JitterTest, NeitherTheLimiterNorTimestampsAbortWhereTheRawStreamDoes) {
  const AbortMap map =
      MapAborts(bench_.config(), streams_.robot, std::vector{0.01, 16.0}, std::vector{1.0}, 3);
  const auto at = [&](Remedy remedy, std::size_t place) {
    return map.all[place][static_cast<std::size_t>(remedy)];
  };
  EXPECT_EQ(at(Remedy::kNone, 1), 1);
  EXPECT_EQ(at(Remedy::kLowPass, 1), 1);
  EXPECT_LT(at(Remedy::kNone, 0), 1);
  EXPECT_EQ(at(Remedy::kLimiter, 1), 0);
  EXPECT_EQ(at(Remedy::kRobotTime, 1), 0);
}

TEST_F(JitterTest, ACrossingCostsTheGeneratorTwoAccelerationsPerCycle) {
  // By the velocity 2 ddq / T, by the position 2 lambda dq / T^2 more at the most.
  const std::vector<PaceResult> paces = MeasurePaces(bench_.config(), streams_, {0.15, 0.5}, 8);
  for (const PaceResult& pace : paces) {
    const double expected = 2 * pace.acceleration * limits_.ddq_max[0] / kT / limits_.dddq_max[0];
    EXPECT_GT(pace.jerk, 0.6 * expected);
    EXPECT_LT(pace.jerk, expected + 0.5);
  }
  EXPECT_EQ(paces[0].aborted, 0);
  EXPECT_GT(paces[1].aborted, 0);
}

TEST_F(JitterTest, TheBriskTrajectoryRunsAtThePaceAskedFor) {
  for (const double share : {0.1, 0.68}) {
    const reference::Trajectory plan = BriskAt(bench_.config(), limits_, share);
    EXPECT_NEAR(Largest(plan.peaks().acceleration), share, 1e-6);
  }
}

TEST(ShareAtLimitTest, IsWhereTheLineThroughThePacesMeetsTheLimit) {
  EXPECT_DOUBLE_EQ(ShareAtLimit({{0.1, 0.5}, {0.2, 0.9}, {0.4, 1.1}}), 0.3);
  EXPECT_TRUE(std::isnan(ShareAtLimit({{0.1, 0.5}, {0.2, 0.9}})));
}

TEST_F(JitterTest, TheSameSettingGivesTheSameFindings) {
  const Config config = bench_.config(1);
  const Findings first = RunJitter(config);
  const Findings second = RunJitter(config);
  ASSERT_EQ(first.comparisons.size(), second.comparisons.size());
  for (std::size_t i = 0; i < first.comparisons.size(); ++i) {
    EXPECT_EQ(first.comparisons[i].ours, second.comparisons[i].ours);
  }
  ASSERT_EQ(first.figures.size(), second.figures.size());
  for (std::size_t i = 0; i < first.figures.size(); ++i) {
    EXPECT_EQ(first.figures[i].values, second.figures[i].values);
    EXPECT_EQ(first.figures[i].rows, second.figures[i].rows);
  }
  EXPECT_EQ(test::FiguresOnPage(first, "jitter"), 4U);
}

}  // namespace
}  // namespace twin::experiment::experiment_jitter_test

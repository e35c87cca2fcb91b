#include "experiment/stream.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"

namespace twin::experiment::experiment_noise_test {
namespace {

using test::ExperimentBench;

constexpr double kT = kCycleSeconds;

class NoiseTest : public ::testing::Test {
 protected:
  [[nodiscard]] NoiseCurves Measure(Remedy remedy, const std::vector<double>& amplitude) const {
    return MeasureNoise(bench_.config(), streams_.robot, remedy, amplitude, 2);
  }

  const ExperimentBench bench_;
  const StreamInputs streams_ = LoadStreamInputs(bench_.config());
  const JointLimits& limits_ = streams_.robot.limits;
};

TEST_F(NoiseTest, NoRawNoiseBelowAnEighthOfTheJerkLimitAborts) {
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double bound = limits_.dddq_max[j] * kT * kT * kT / 8;
    EXPECT_EQ(Measure(Remedy::kNone, {0.99 * bound}).aborted[j][0], 0) << "joint " << j + 1;
    EXPECT_EQ(Measure(Remedy::kNone, {3 * bound}).aborted[j][0], 1) << "joint " << j + 1;
  }
}

TEST_F(NoiseTest, RawNoiseLeavesTheThirdDifferenceOfUniformSamples) {
  // Deviation e / sqrt(3), of the third difference sqrt(20) times that.
  const NoiseCurves curves = Measure(Remedy::kNone, {1e-5});
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double expected = 1e-5 * std::sqrt(20.0 / 3) / (kT * kT * kT) / limits_.dddq_max[j];
    EXPECT_NEAR(curves.rms_jerk[j][0] / expected, 1, 0.05) << "joint " << j + 1;
  }
}

TEST_F(NoiseTest, TheGeneratorPassesNoiseOnWholeWhenItsVelocityIsFormedFromIt) {
  const double raw = Measure(Remedy::kNone, {1e-5}).rms_jerk[0][0];
  EXPECT_NEAR(Measure(Remedy::kGenerator, {1e-5}).rms_jerk[0][0] / raw, 1, 0.01);
}

TEST_F(NoiseTest, OfAGivenVelocityItPassesLambdaTimesTheSecondDifference) {
  const double raw = Measure(Remedy::kNone, {1e-3}).rms_jerk[0][0];
  const double given = Measure(Remedy::kGivenVelocity, {1e-3}).rms_jerk[0][0];
  EXPECT_NEAR(given / raw, 1e-3 * std::sqrt(6.0 / 20), 0.05 * given / raw);
}

TEST_F(NoiseTest, TheLimiterKeepsItsLimitWhateverTheNoise) {
  const NoiseCurves curves = Measure(Remedy::kLimiter, {1e-6, 1e-4, 1e-2});
  for (const auto& aborted : curves.aborted) {
    for (const double share : aborted) EXPECT_EQ(share, 0);
  }
  EXPECT_GT(curves.rms_jerk[0][1], 0.1) << "it shakes";
}

TEST_F(NoiseTest, RateMatchingAndLowPassBearMoreThanARawStream) {
  const double amplitude = 2 * limits_.dddq_max[0] * kT * kT * kT / 8;
  EXPECT_EQ(Measure(Remedy::kNone, {amplitude}).aborted[0][0], 1);
  EXPECT_EQ(Measure(Remedy::kRateMatching, {amplitude}).aborted[0][0], 0);
  EXPECT_EQ(Measure(Remedy::kLowPass, {amplitude}).aborted[0][0], 0);
}

TEST(HalfAbortedTest, IsInterpolatedOnALogarithmicScale) {
  NoiseCurves curves{.amplitude = {1e-6, 1e-4}, .aborted = {}, .rms_jerk = {}};
  curves.aborted[0] = {0, 1};
  EXPECT_NEAR(HalfAborted(curves, 0), 1e-5, 1e-12);
  curves.aborted[0] = {1, 1};
  EXPECT_EQ(HalfAborted(curves, 0), 1e-6);
  curves.aborted[0] = {0, 0.4};
  EXPECT_EQ(HalfAborted(curves, 0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace twin::experiment::experiment_noise_test

#include "experiment/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "twin/core/random.h"

namespace twin::experiment::experiment_spectrum_test {
namespace {

constexpr double kRateHz = 1000;
constexpr std::size_t kSegment = 1024;

std::vector<double> Sine(double amplitude, double frequency_hz, double phase, std::size_t size) {
  std::vector<double> signal(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double t = static_cast<double>(i) / kRateHz;
    signal[i] = amplitude * std::cos(2 * std::numbers::pi * frequency_hz * t + phase);
  }
  return signal;
}

TEST(WelchTest, ASinesPowerIsHalfItsAmplitudeSquared) {
  const Spectrum spectrum = Welch(Sine(0.3, 62.5, 0.4, 16384));
  EXPECT_NEAR(BandPower(spectrum, 55, 70), 0.3 * 0.3 / 2, 1e-6);
}

TEST(WelchTest, ASineLeavesNextToNothingInABandItIsNotIn) {
  const Spectrum spectrum = Welch(Sine(1, 2.2, 0, 16384));
  EXPECT_LT(BandPower(spectrum, 20, 150), 1e-7);
}

TEST(WelchTest, WhiteNoiseHasItsVarianceSpreadOverAllFrequencies) {
  constexpr std::size_t kSize = 65536;
  constexpr double kSigma = 1e-3;
  const Random random(1, RandomStream::kTest);
  std::vector<double> noise(kSize);
  for (std::size_t i = 0; i < kSize; ++i) noise[i] = kSigma * random.Normal(i);
  const Spectrum spectrum = Welch(noise);
  // 130 Hz of 500: 133 values of some 127 segments that overlap by half, so about 1 % of scatter.
  EXPECT_NEAR(BandPower(spectrum, 20, 150) / (kSigma * kSigma * 130 / 500), 1, 0.05);
}

TEST(WelchTest, TheMedianOfSegmentsTakesNoNoteOfABurst) {
  std::vector<double> signal = Sine(0.1, 62.5, 0, 8 * kSegment);
  const std::vector<double> burst = Sine(50, 62.5, 0, kSegment);
  std::ranges::copy(burst, signal.begin());
  EXPECT_NEAR(MedianBandPower(signal, 55, 70), 0.1 * 0.1 / 2, 1e-6);
}

TEST(WelchTest, AConstantHasNoPower) {
  const Spectrum spectrum = Welch(std::vector<double>(4096, 3.0));
  EXPECT_LT(BandPower(spectrum, 0, 500), 1e-20);
}

TEST(WelchTest, ASignalShorterThanASegmentHasNoDensity) {
  EXPECT_TRUE(Welch(std::vector<double>(100, 1.0)).density.empty());
}

TEST(SineAmplitudeTest, FindsAmplitudeAndPhaseBesideAStraightLine) {
  std::vector<double> signal = Sine(0.2, 0.7, 0.9, 5000);
  for (std::size_t i = 0; i < signal.size(); ++i) signal[i] += 4 + 1e-3 * static_cast<double>(i);
  const std::complex<double> amplitude = SineAmplitude(signal, 0.7);
  EXPECT_NEAR(std::abs(amplitude), 0.2, 1e-9);
  EXPECT_NEAR(std::arg(amplitude), 0.9, 1e-9);
}

}  // namespace
}  // namespace twin::experiment::experiment_spectrum_test

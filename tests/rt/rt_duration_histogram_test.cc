#include "twin/rt/duration_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/realtime_guard.h"
#include "twin/core/random.h"

namespace twin::rt::rt_duration_histogram_test {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;

/// The value itself: the smallest with at least `share` of all at or below it.
Duration ExactPercentile(std::vector<Duration> values, double share) {
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(1, rank) - 1];
}

TEST(DurationHistogramTest, IsZeroBeforeTheFirstValue) {
  const DurationHistogram histogram;
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.min(), Duration{});
  EXPECT_EQ(histogram.max(), Duration{});
  EXPECT_EQ(histogram.Percentile(0.5), Duration{});
}

TEST(DurationHistogramTest, AnOnlyValueIsEveryPercentile) {
  DurationHistogram histogram;
  histogram.Add(Duration(1234567));
  for (const double share : {0.0, 0.001, 0.5, 1.0}) {
    EXPECT_EQ(histogram.Percentile(share), Duration(1234567)) << share;
  }
}

TEST(DurationHistogramTest, PercentilesOfWidelySpreadValuesAreRightWithinABin) {
  DurationHistogram histogram;
  std::vector<Duration> values;
  const Random random(11, RandomStream::kTest);
  for (std::uint64_t i = 0; i < 20000; ++i) {
    // From 1 ns to about 1000 s, evenly in the logarithm.
    values.push_back(Duration(std::llround(std::pow(10.0, 12 * random.Uniform(i)))));
    histogram.Add(values.back());
  }
  for (const double share : {0.0, 0.01, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999, 0.9999, 1.0}) {
    const auto exact = static_cast<double>(ExactPercentile(values, share).count());
    const auto got = static_cast<double>(histogram.Percentile(share).count());
    EXPECT_GE(got, exact) << share;
    EXPECT_LE(got, exact * (1 + 1.0 / 256)) << share;
  }
  EXPECT_EQ(histogram.min(), *std::min_element(values.begin(), values.end()));
  EXPECT_EQ(histogram.max(), *std::max_element(values.begin(), values.end()));
  EXPECT_EQ(histogram.count(), values.size());
}

TEST(DurationHistogramTest, ValuesAtTheEdgesOfTheBinsKeepTheirOrder) {
  // At each power of two: the last value before, itself, the first behind.
  for (int power = 1; power < 40; ++power) {
    const std::int64_t edge = std::int64_t{1} << power;
    DurationHistogram histogram;
    for (const std::int64_t ns : {edge - 1, edge, edge + 1}) histogram.Add(Duration(ns));
    const Duration low = histogram.Percentile(0.3);
    const Duration high = histogram.Percentile(1);
    EXPECT_GE(low, Duration(edge - 1)) << power;
    EXPECT_LE(low, high) << power;
    EXPECT_EQ(high, Duration(edge + 1)) << power;
  }
}

TEST(DurationHistogramTest, ValuesBelowSixtyFourNanosecondsAreExact) {
  DurationHistogram histogram;
  for (int ns = 0; ns < 64; ++ns) histogram.Add(Duration(ns));
  for (int n = 1; n <= 64; ++n) EXPECT_EQ(histogram.Percentile(n / 64.0), Duration(n - 1));
}

TEST(DurationHistogramTest, CountsWhatIsOutsideItsRangeAsTheNearestInside) {
  DurationHistogram histogram;
  histogram.Add(Duration(-5));
  histogram.Add(hours(24));
  EXPECT_EQ(histogram.count(), 2u);
  EXPECT_EQ(histogram.min(), Duration{});
  EXPECT_EQ(histogram.max(), Duration(std::int64_t{1} << 40));
  EXPECT_EQ(histogram.Percentile(0.5), Duration{});
  EXPECT_EQ(histogram.Percentile(1), histogram.max());
}

TEST(DurationHistogramTest, ResetForgetsEverything) {
  DurationHistogram histogram;
  histogram.Add(microseconds(7));
  histogram.Reset();
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.Percentile(1), Duration{});
}

TEST(DurationHistogramTest, AddsWithoutAllocation) {
  DurationHistogram histogram;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) histogram.Add(microseconds(i));
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::rt::rt_duration_histogram_test

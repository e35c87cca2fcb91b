#include "twin/rt/delay_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::rt {
namespace {

using std::chrono::microseconds;
using ::testing::HasSubstr;

constexpr LogNormalDelay kTypical{
    .median = microseconds(200), .sigma = 0.5, .offset = microseconds(50)};

TEST(DelayModelTest, IsNoDelayByDefault) {
  EXPECT_EQ(DelayModel().Draw(Random(1, RandomStream::kTest), 0), Duration::zero());
}

TEST(DelayModelTest, ConstantIsTheSameAtEveryTick) {
  const DelayModel model(ConstantDelay{.value = microseconds(300)});
  const Random random(1, RandomStream::kTest);
  for (std::uint64_t tick = 0; tick < 100; ++tick) {
    EXPECT_EQ(model.Draw(random, tick), microseconds(300));
  }
}

TEST(DelayModelTest, LogNormalIsAFunctionOfSeedStreamAndTick) {
  const DelayModel model(kTypical);
  const Random random(1, RandomStream::kTest);
  EXPECT_EQ(model.Draw(random, 5), model.Draw(Random(1, RandomStream::kTest), 5));
  EXPECT_NE(model.Draw(random, 5), model.Draw(random, 6));
  EXPECT_NE(model.Draw(random, 5), model.Draw(Random(2, RandomStream::kTest), 5));
  EXPECT_NE(model.Draw(random, 5), model.Draw(Random(1, RandomStream::kStateDelay), 5));
}

TEST(DelayModelTest, LogNormalWithoutSpreadIsItsMedianPlusOffset) {
  const DelayModel model(
      LogNormalDelay{.median = microseconds(200), .sigma = 0, .offset = microseconds(50)});
  EXPECT_EQ(model.Draw(Random(1, RandomStream::kTest), 17), microseconds(250));
}

struct Quantile {
  double p;
  double z;  ///< of the standard normal
};
void PrintTo(const Quantile& quantile, std::ostream* out) {
  *out << quantile.p;
}

class LogNormalQuantileTest : public testing::TestWithParam<Quantile> {};

TEST_P(LogNormalQuantileTest, MatchesTheFormula) {
  constexpr std::size_t kDraws = 100'000;
  const DelayModel model(kTypical);
  const Random random(1, RandomStream::kTest);
  std::vector<Duration> sample(kDraws);
  for (std::size_t i = 0; i < kDraws; ++i) sample[i] = model.Draw(random, i);
  std::sort(sample.begin(), sample.end());

  const auto [p, z] = GetParam();
  const double beyond_offset =
      ToSeconds(sample[static_cast<std::size_t>(p * kDraws)] - kTypical.offset);
  const double expected = ToSeconds(kTypical.median) * std::exp(kTypical.sigma * z);
  // Five standard errors of a sample quantile, sqrt(p (1 - p) / n) / density.
  const double normal_density = std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
  const double density = normal_density / (kTypical.sigma * expected);
  EXPECT_NEAR(beyond_offset, expected, 5 * std::sqrt(p * (1 - p) / kDraws) / density);
}

INSTANTIATE_TEST_SUITE_P(P, LogNormalQuantileTest,
                         testing::Values(Quantile{0.01, -2.3263478740408408}, Quantile{0.5, 0.0},
                                         Quantile{0.99, 2.3263478740408408}));

TEST(DelayModelTest, LogNormalNeverFallsBelowItsOffset) {
  const DelayModel model(kTypical);
  const Random random(9, RandomStream::kTest);
  for (std::uint64_t tick = 0; tick < 10'000; ++tick) {
    ASSERT_GE(model.Draw(random, tick), kTypical.offset);
  }
}

/// The text a delay is refused with; empty when it is accepted.
template <typename Parameters>
std::string RefusalOf(const Parameters& parameters) {
  try {
    const DelayModel model(parameters);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(DelayModelTest, RefusesParametersOutsideTheirRangeByName) {
  EXPECT_THAT(RefusalOf(ConstantDelay{.value = Duration(-1)}), HasSubstr("value"));
  LogNormalDelay delay = kTypical;
  delay.median = Duration::zero();
  EXPECT_THAT(RefusalOf(delay), HasSubstr("median"));
  delay = kTypical;
  delay.offset = Duration(-1);
  EXPECT_THAT(RefusalOf(delay), HasSubstr("offset"));
  delay = kTypical;
  delay.sigma = -0.1;
  EXPECT_THAT(RefusalOf(delay), HasSubstr("sigma"));
  delay.sigma = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(RefusalOf(delay), HasSubstr("sigma"));
}

TEST(DelayModelTest, DrawsWithoutAllocation) {
  const DelayModel model(kTypical);
  const Random random(1, RandomStream::kTest);
  const test::RealtimeGuard guard;
  Duration sum{0};
  for (std::uint64_t tick = 0; tick < 1000; ++tick) sum += model.Draw(random, tick);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_GT(sum, Duration::zero());
}

}  // namespace
}  // namespace twin::rt

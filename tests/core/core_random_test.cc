#include "twin/core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "support/realtime_guard.h"

namespace twin::core_random_test {
namespace {

using Words = std::array<std::uint32_t, 4>;

/// Philox with the counter and key of a published vector, put into the places Random has for them.
Words Philox(const Words& counter, std::uint64_t key) {
  const Random random(key, static_cast<RandomStream>(counter[2]));
  return random.Bits(std::uint64_t{counter[1]} << 32 | counter[0], counter[3]);
}

// Known answers: Random123, tests/kat_vectors, philox 4x32 10 rounds.
TEST(RandomTest, GivesTheKnownAnswerForZeros) {
  EXPECT_EQ(Philox({0, 0, 0, 0}, 0), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
}

TEST(RandomTest, GivesTheKnownAnswerForOnes) {
  constexpr std::uint32_t kOnes = 0xffffffff;
  EXPECT_EQ(Philox({kOnes, kOnes, kOnes, kOnes}, ~std::uint64_t{0}),
            (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
}

TEST(RandomTest, GivesTheKnownAnswerForDigitsOfPi) {
  EXPECT_EQ(Philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0x299f31d0'a4093822),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomTest, UniformIsTheTop53BitsOfTheFirstTwoWords) {
  const Random random(7, RandomStream::kTest);
  for (std::uint64_t tick = 0; tick < 100; ++tick) {
    const Words bits = random.Bits(tick);
    const double first = std::ldexp(static_cast<double>(bits[0]), -32);
    const double second = std::ldexp(static_cast<double>(bits[1] >> 11), -53);
    EXPECT_EQ(random.Uniform(tick), first + second) << "tick " << tick;
  }
}

TEST(RandomTest, UniformStaysInItsRangeAndHasItsMoments) {
  constexpr int kDraws = 200'000;
  const Random random(1, RandomStream::kTest);
  double sum = 0;
  double squares = 0;
  double least = 1;
  double most = 0;
  for (int tick = 0; tick < kDraws; ++tick) {
    const double x = random.Uniform(static_cast<std::uint64_t>(tick));
    sum += x;
    squares += (x - 0.5) * (x - 0.5);
    least = std::min(least, x);
    most = std::max(most, x);
  }
  EXPECT_GE(least, 0.0);
  EXPECT_LT(most, 1.0);
  // Five standard errors: of the mean 1 / sqrt(12 n), of the variance 1 / sqrt(180 n).
  EXPECT_NEAR(sum / kDraws, 0.5, 5 / std::sqrt(12.0 * kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0 / 12, 5 / std::sqrt(180.0 * kDraws));
}

TEST(RandomTest, NormalHasItsFirstFourMoments) {
  constexpr int kDraws = 400'000;
  const Random random(1, RandomStream::kTest);
  std::array<double, 5> moment{};
  for (int tick = 0; tick < kDraws; ++tick) {
    const double z = random.Normal(static_cast<std::uint64_t>(tick));
    double power = 1;
    for (double& m : moment) {
      m += power / kDraws;
      power *= z;
    }
  }
  // Five standard errors sqrt((E z^2k - (E z^k)^2) / n) with E z^2, z^4, z^6, z^8 = 1, 3, 15, 105.
  EXPECT_NEAR(moment[1], 0, 5 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(moment[2], 1, 5 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(moment[3], 0, 5 * std::sqrt(15.0 / kDraws));
  EXPECT_NEAR(moment[4], 3, 5 * std::sqrt(96.0 / kDraws));
}

TEST(RandomTest, NormalHasItsDistributionFunction) {
  constexpr std::size_t kDraws = 100'000;
  const Random random(3, RandomStream::kTest);
  std::vector<double> sample(kDraws);
  for (std::size_t i = 0; i < kDraws; ++i) sample[i] = random.Normal(i);
  std::sort(sample.begin(), sample.end());
  double distance = 0;
  for (std::size_t i = 0; i < kDraws; ++i) {
    const double expected = 0.5 * std::erfc(-sample[i] / std::sqrt(2.0));
    distance = std::max(distance, std::abs(static_cast<double>(i + 1) / kDraws - expected));
  }
  // Kolmogorov-Smirnov: larger than 1.95 / sqrt(n) has probability 0.001.
  EXPECT_LT(distance, 1.95 / std::sqrt(static_cast<double>(kDraws)));
}

TEST(RandomTest, SeedStreamTickAndDrawEachChangeTheNumber) {
  std::set<Words> seen;
  int draws = 0;
  for (const std::uint64_t seed : {0ULL, 1ULL, 1ULL << 32}) {
    for (const RandomStream stream : {RandomStream::kStateDelay, RandomStream::kCommandDelay}) {
      for (const std::uint64_t tick : {0ULL, 1ULL, 1ULL << 32}) {
        for (const std::uint32_t draw : {0U, 1U}) {
          seen.insert(Random(seed, stream).Bits(tick, draw));
          ++draws;
        }
      }
    }
  }
  EXPECT_EQ(static_cast<int>(seen.size()), draws);
}

TEST(RandomTest, NeighbouringTicksAndStreamsAreUncorrelated) {
  constexpr int kDraws = 100'000;
  const Random a(5, RandomStream::kStateDelay);
  const Random b(5, RandomStream::kCommandDelay);
  double next_tick = 0;
  double other_stream = 0;
  for (int i = 0; i < kDraws; ++i) {
    const auto tick = static_cast<std::uint64_t>(i);
    next_tick += a.Normal(tick) * a.Normal(tick + 1) / kDraws;
    other_stream += a.Normal(tick) * b.Normal(tick) / kDraws;
  }
  EXPECT_NEAR(next_tick, 0, 5 / std::sqrt(static_cast<double>(kDraws)));
  EXPECT_NEAR(other_stream, 0, 5 / std::sqrt(static_cast<double>(kDraws)));
}

TEST(RandomTest, DrawsWithoutAllocation) {
  const Random random(1, RandomStream::kTest);
  const test::RealtimeGuard guard;
  double sum = 0;
  for (std::uint64_t tick = 0; tick < 1000; ++tick) {
    sum += random.Uniform(tick) + random.Normal(tick);
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace twin::core_random_test

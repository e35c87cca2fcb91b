#include "twin/faults/delay_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::faults::faults_delay_model_test {
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

TEST(DelayModelTest, LogNormalIsTheFormulaOfOneNormalDraw) {
  const DelayModel model(kTypical);
  const Random random(1, RandomStream::kTest);
  for (std::uint64_t tick = 0; tick < 1000; ++tick) {
    const double factor = std::exp(kTypical.sigma * random.Normal(tick));
    ASSERT_EQ(model.Draw(random, tick),
              kTypical.offset + FromSeconds(ToSeconds(kTypical.median) * factor));
  }
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

/// A model and what its draws must look like.
struct Expected {
  std::string name;
  DelayModel model;
  std::function<double(double)> distribution;  ///< P(delay <= seconds); empty: no closed form
  double mean = 0;                             ///< s
  double standard_deviation = 0;               ///< s
};
void PrintTo(const Expected& expected, std::ostream* out) {
  *out << expected.name;
}

double NormalDistribution(double z) {
  return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

/// N(mean, sigma^2) given that it is not negative.
Expected Normal(std::string name, Duration mean, Duration sigma) {
  const double m = ToSeconds(mean);
  const double s = ToSeconds(sigma);
  const double r = m / s;
  const double kept = NormalDistribution(r);
  const double density = std::exp(-0.5 * r * r) / std::sqrt(2 * std::numbers::pi);
  const double hazard = density / kept;
  return {.name = std::move(name),
          .model = DelayModel(NormalDelay{.mean = mean, .sigma = sigma}),
          .distribution =
              [=](double x) { return (NormalDistribution((x - m) / s) - (1 - kept)) / kept; },
          .mean = m + s * hazard,
          .standard_deviation = s * std::sqrt(1 - r * hazard - hazard * hazard)};
}

constexpr Duration kScale = microseconds(100);
constexpr Duration kOffset = microseconds(30);

/// @param distribution  of the gamma variable with scale 1; may be empty.
Expected Gamma(std::string name, double shape, const std::function<double(double)>& distribution) {
  Expected expected{
      .name = std::move(name),
      .model = DelayModel(GammaDelay{.shape = shape, .scale = kScale, .offset = kOffset}),
      .distribution = {},
      .mean = ToSeconds(kOffset) + shape * ToSeconds(kScale),
      .standard_deviation = std::sqrt(shape) * ToSeconds(kScale)};
  if (distribution) {
    expected.distribution = [=](double x) {
      return distribution(ToSeconds(FromSeconds(x) - kOffset) / ToSeconds(kScale));
    };
  }
  return expected;
}

/// Three bins of 1, 2 and 1 ms with weights 3, 1 and 0, and one of 4 ms with 4.
Expected Histogram() {
  constexpr double kMs = 1e-3;
  const EmpiricalDelay measured{
      .edges = {microseconds(1000), microseconds(2000), microseconds(4000), microseconds(5000),
                microseconds(9000)},
      .weights = {3, 1, 0, 4}};
  // Of a mixture of uniforms: centre c and width w of each.
  const double mean = (3 * 1.5 + 1 * 3 + 4 * 7) / 8;
  const double square = (3 * (1.5 * 1.5 + 1.0 / 12) + (9 + 4.0 / 12) + 4 * (49 + 16.0 / 12)) / 8;
  return {.name = "Histogram",
          .model = DelayModel(measured),
          .distribution =
              [](double seconds) {
                const double x = seconds / kMs;
                return (3 * std::clamp(x - 1, 0.0, 1.0) + std::clamp((x - 2) / 2, 0.0, 1.0) +
                        4 * std::clamp((x - 5) / 4, 0.0, 1.0)) /
                       8;
              },
          .mean = mean * kMs,
          .standard_deviation = std::sqrt(square - mean * mean) * kMs};
}

class DelayDistributionTest : public testing::TestWithParam<Expected> {
 protected:
  static constexpr std::size_t kDraws = 100'000;

  DelayDistributionTest() : sample_(kDraws) {
    const Random random(21, RandomStream::kTest);
    for (std::size_t i = 0; i < kDraws; ++i) {
      sample_[i] = ToSeconds(GetParam().model.Draw(random, i));
    }
    std::sort(sample_.begin(), sample_.end());
  }

  std::vector<double> sample_;  ///< s, rising
};

TEST_P(DelayDistributionTest, HasTheMeanAndTheSpreadOfItsFormula) {
  const double n = kDraws;
  const double mean = std::accumulate(sample_.begin(), sample_.end(), 0.0) / n;
  double second = 0;
  double fourth = 0;
  for (const double x : sample_) {
    second += std::pow(x - mean, 2) / n;
    fourth += std::pow(x - mean, 4) / n;
  }
  const double s = GetParam().standard_deviation;
  EXPECT_NEAR(mean, GetParam().mean, 5 * s / std::sqrt(n));
  // Standard error of a variance: sqrt((m4 - s^4) / n).
  EXPECT_NEAR(second, s * s, 5 * std::sqrt((fourth - second * second) / n));
}

class DelayFormulaTest : public DelayDistributionTest {};

TEST_P(DelayFormulaTest, FollowsItsDistributionFunction) {
  double distance = 0;  // Kolmogorov-Smirnov
  for (std::size_t i = 0; i < kDraws; ++i) {
    const double expected = GetParam().distribution(sample_[i]);
    distance = std::max({distance, expected - static_cast<double>(i) / kDraws,
                         static_cast<double>(i + 1) / kDraws - expected});
  }
  EXPECT_LT(distance * std::sqrt(kDraws), 1.95);  // exceeded once in 1000 when all is right
}

TEST_P(DelayDistributionTest, IsNeverNegative) {
  EXPECT_GE(sample_.front(), 0);
}

std::string NameOf(const testing::TestParamInfo<Expected>& info) {
  return info.param.name;
}

const std::vector<Expected> kWithFormula{
    Normal("NormalFarFromZero", microseconds(500), microseconds(50)),
    Normal("NormalCutAtOneSigma", microseconds(100), microseconds(100)),
    Normal("NormalCutInHalf", microseconds(0), microseconds(100)),
    Gamma("GammaBelowOne", 0.5, [](double x) { return std::erf(std::sqrt(x)); }),
    Gamma("Exponential", 1, [](double x) { return 1 - std::exp(-x); }),
    Gamma("GammaTwo", 2, [](double x) { return 1 - std::exp(-x) * (1 + x); }),
    Gamma("GammaThree", 3, [](double x) { return 1 - std::exp(-x) * (1 + x + x * x / 2); }),
    Histogram()};

INSTANTIATE_TEST_SUITE_P(Formula, DelayDistributionTest, testing::ValuesIn(kWithFormula), NameOf);
INSTANTIATE_TEST_SUITE_P(Formula, DelayFormulaTest, testing::ValuesIn(kWithFormula), NameOf);
INSTANTIATE_TEST_SUITE_P(Moments, DelayDistributionTest,
                         testing::Values(Gamma("GammaFarBelowOne", 0.1, {}),
                                         Gamma("GammaLarge", 400, {})),
                         NameOf);

TEST(DelayModelTest, NormalWithoutSpreadIsItsMean) {
  const DelayModel model(NormalDelay{.mean = microseconds(200), .sigma = Duration(0)});
  EXPECT_EQ(model.Draw(Random(1, RandomStream::kTest), 17), microseconds(200));
}

TEST(DelayModelTest, GammaNeverFallsBelowItsOffset) {
  const DelayModel model(GammaDelay{.shape = 0.05, .scale = kScale, .offset = kOffset});
  const Random random(9, RandomStream::kTest);
  for (std::uint64_t tick = 0; tick < 10'000; ++tick) {
    ASSERT_GE(model.Draw(random, tick), kOffset);
  }
}

TEST(DelayModelTest, AHistogramStaysWithinItsBinsAndOutOfThoseWithoutWeight) {
  const DelayModel model(EmpiricalDelay{
      .edges = {Duration(10), Duration(20), Duration(30), Duration(40)}, .weights = {1, 0, 1e-3}});
  const Random random(9, RandomStream::kTest);
  std::set<std::int64_t> seen;
  for (std::uint64_t tick = 0; tick < 100'000; ++tick)
    seen.insert(model.Draw(random, tick).count());
  std::set<std::int64_t> allowed;
  for (std::int64_t ns = 10; ns < 20; ++ns) allowed.insert({ns, ns + 20});
  EXPECT_EQ(seen, allowed);
}

TEST(DelayModelTest, EveryModelIsAFunctionOfSeedStreamAndTick) {
  for (const DelayModel& model :
       {DelayModel(NormalDelay{microseconds(50), microseconds(50)}),
        DelayModel(GammaDelay{0.7, kScale, kOffset}),
        DelayModel(EmpiricalDelay{{Duration(0), microseconds(500)}, {1}})}) {
    const Random random(1, RandomStream::kTest);
    EXPECT_EQ(model.Draw(random, 5), model.Draw(Random(1, RandomStream::kTest), 5));
    EXPECT_NE(model.Draw(random, 5), model.Draw(random, 6));
    EXPECT_NE(model.Draw(random, 5), model.Draw(Random(2, RandomStream::kTest), 5));
    EXPECT_NE(model.Draw(random, 5), model.Draw(Random(1, RandomStream::kStateDelay), 5));
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

TEST(DelayModelTest, RefusesANormalOutOfRangeByName) {
  EXPECT_THAT(RefusalOf(NormalDelay{.mean = Duration(-1), .sigma = Duration(1)}),
              HasSubstr("mean is -1 ns"));
  EXPECT_THAT(RefusalOf(NormalDelay{.mean = Duration(1), .sigma = Duration(-1)}),
              HasSubstr("sigma is -1 ns"));
}

TEST(DelayModelTest, RefusesAGammaOutOfRangeByName) {
  for (const double shape : {0.0, -1.0, 1e7, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(RefusalOf(GammaDelay{shape, kScale, kOffset}), HasSubstr("shape")) << shape;
  }
  EXPECT_THAT(RefusalOf(GammaDelay{1, Duration(0), kOffset}), HasSubstr("scale"));
  EXPECT_THAT(RefusalOf(GammaDelay{1, kScale, Duration(-1)}), HasSubstr("offset"));
}

TEST(DelayModelTest, RefusesAHistogramThatIsNone) {
  const auto refusal = [](const std::vector<std::int64_t>& edges, std::vector<double> weights) {
    EmpiricalDelay empirical;
    for (const std::int64_t edge : edges) empirical.edges.emplace_back(edge);
    empirical.weights = std::move(weights);
    return RefusalOf(empirical);
  };
  EXPECT_THAT(refusal({}, {}), HasSubstr("0 edges and 0 weights"));
  EXPECT_THAT(refusal({1}, {}), HasSubstr("1 edges and 0 weights"));
  EXPECT_THAT(refusal({1, 2}, {1, 1}), HasSubstr("2 edges and 2 weights"));
  EXPECT_THAT(refusal({1, 3, 3}, {1, 1}), HasSubstr("edges[2] is 3 ns"));
  EXPECT_THAT(refusal({-1, 3}, {1}), HasSubstr("edges[0] is -1 ns"));
  EXPECT_THAT(refusal({1, 2, 3}, {1, -1}), HasSubstr("weights[1] is -1"));
  EXPECT_THAT(refusal({1, 2}, {std::numeric_limits<double>::infinity()}), HasSubstr("weights[0]"));
  EXPECT_THAT(refusal({1, 2}, {std::numeric_limits<double>::quiet_NaN()}), HasSubstr("weights[0]"));
  EXPECT_THAT(refusal({1, 2, 3}, {0, 0}), HasSubstr("all weights are 0"));
  EXPECT_EQ(refusal({0, 2, 3}, {0, 1e-9}), "");
}

TEST(DelayModelTest, RefusesADelayOfMoreThanAnHour) {
  const Duration most = DelayModel::kLongestParameter;
  EXPECT_EQ(RefusalOf(ConstantDelay{most}), "");
  EXPECT_THAT(RefusalOf(ConstantDelay{most + Duration(1)}), HasSubstr("value"));
  EXPECT_THAT(RefusalOf(LogNormalDelay{most + Duration(1), 1, {}}), HasSubstr("median"));
  EXPECT_THAT(RefusalOf(EmpiricalDelay{{Duration(0), most + Duration(1)}, {1}}),
              HasSubstr("edges[1]"));
}

TEST(DelayModelTest, DrawsWithoutAllocation) {
  const Random random(1, RandomStream::kTest);
  for (const DelayModel& model :
       {DelayModel(ConstantDelay{kScale}), DelayModel(kTypical),
        DelayModel(NormalDelay{microseconds(0), microseconds(50)}),
        DelayModel(GammaDelay{0.3, kScale, kOffset}),
        DelayModel(EmpiricalDelay{{Duration(0), kScale, 2 * kScale}, {1, 2}})}) {
    const test::RealtimeGuard guard;
    Duration sum{0};
    for (std::uint64_t tick = 0; tick < 1000; ++tick) sum += model.Draw(random, tick);
    const auto counts = guard.counts();
    EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
    EXPECT_GT(sum, Duration::zero());
  }
}

}  // namespace
}  // namespace twin::faults::faults_delay_model_test

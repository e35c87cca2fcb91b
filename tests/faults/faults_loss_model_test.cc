#include "twin/faults/loss_model.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::faults::faults_loss_model_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::uint64_t kSeed = 7;

/// Every message in a burst is lost, none outside: the losses show the chain.
constexpr GilbertElliottLoss kBursts{
    .good_to_bad = 0.02, .bad_to_good = 0.2, .loss_good = 0, .loss_bad = 1};

LossProcess Process(LossModel model, std::uint64_t seed = kSeed) {
  return {std::move(model), seed, RandomStream::kStateLoss, RandomStream::kStateBurst};
}

/// The fates of messages 0 to n-1, asked for in order.
std::vector<bool> Losses(const LossModel& model, std::uint64_t n, std::uint64_t seed = kSeed) {
  LossProcess process = Process(model, seed);
  std::vector<bool> losses(n);
  for (std::uint64_t i = 0; i < n; ++i) losses[i] = process.Loses(i);
  return losses;
}

double Share(const std::vector<bool>& losses) {
  const auto count = std::accumulate(losses.begin(), losses.end(), std::int64_t{0});
  return static_cast<double>(count) / static_cast<double>(losses.size());
}

/// Lengths of the runs of losses.
std::vector<double> BurstLengths(const std::vector<bool>& losses) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < losses.size(); ++i) {
    if (!losses[i]) continue;
    if (i == 0 || !losses[i - 1]) lengths.push_back(0);
    ++lengths.back();
  }
  return lengths;
}

TEST(LossProcessTest, LosesNothingByDefault) {
  EXPECT_EQ(Share(Losses(LossModel(), 1000)), 0);
}

TEST(LossProcessTest, AnIndependentLossIsOneDrawOfTheLossStream) {
  const auto losses = Losses(LossModel(IndependentLoss{0.3}), 1000);
  const Random random(kSeed, RandomStream::kStateLoss);
  for (std::uint64_t n = 0; n < losses.size(); ++n) {
    ASSERT_EQ(losses[n], random.Uniform(n) < 0.3) << n;
  }
}

class LossShareTest : public testing::TestWithParam<double> {};

TEST_P(LossShareTest, IndependentLossHasTheGivenShare) {
  constexpr std::uint64_t kMessages = 200'000;
  const double p = GetParam();
  // 5 standard deviations: exact for 0 and 1.
  EXPECT_NEAR(Share(Losses(LossModel(IndependentLoss{p}), kMessages)), p,
              5 * std::sqrt(p * (1 - p) / kMessages));
}

INSTANTIATE_TEST_SUITE_P(Shares, LossShareTest, testing::Values(0.0, 0.001, 0.02, 0.5, 1.0));

class GilbertElliottTest : public testing::TestWithParam<GilbertElliottLoss> {
 protected:
  static constexpr std::uint64_t kMessages = 1'000'000;
  const GilbertElliottLoss& chain() const { return GetParam(); }
  double bad_share() const {
    return chain().good_to_bad / (chain().good_to_bad + chain().bad_to_good);
  }
};

TEST_P(GilbertElliottTest, HasTheStationaryShareOfLosses) {
  const double bad = bad_share();
  const double share = bad * chain().loss_bad + (1 - bad) * chain().loss_good;
  // Variance of a mean of N messages: of one message, and the chain's memory, whose correlation
  // falls by lambda = 1 - p - r per message.
  const double lambda = 1 - chain().good_to_bad - chain().bad_to_good;
  const double contrast = chain().loss_bad - chain().loss_good;
  const double memory = bad * (1 - bad) * contrast * contrast * 2 * lambda / (1 - lambda);
  const double variance = (share * (1 - share) + memory) / kMessages;
  EXPECT_NEAR(Share(Losses(LossModel(chain()), kMessages)), share, 5 * std::sqrt(variance));
}

TEST_P(GilbertElliottTest, HasTheMeanBurstLength) {
  GilbertElliottLoss visible = chain();
  visible.loss_good = 0;
  visible.loss_bad = 1;
  const auto lengths = BurstLengths(Losses(LossModel(visible), kMessages));
  const double count = static_cast<double>(lengths.size());
  const double mean = std::accumulate(lengths.begin(), lengths.end(), 0.0) / count;
  const double r = visible.bad_to_good;
  // Geometric: mean 1/r, variance (1-r)/r^2. A burst that a block's start meets is cut or grows: at
  // most one in kBlock messages, wrong by about its mean.
  const double blocks = static_cast<double>(kMessages) / LossProcess::kBlock;
  const double cut = blocks / count / r * bad_share();
  EXPECT_NEAR(mean, 1 / r, 5 * std::sqrt((1 - r) / count) / r + cut);
}

INSTANTIATE_TEST_SUITE_P(Chains, GilbertElliottTest,
                         testing::Values(kBursts, GilbertElliottLoss{0.001, 0.05, 0, 1},
                                         GilbertElliottLoss{0.01, 0.1, 0.005, 0.5},
                                         GilbertElliottLoss{0.5, 0.5, 0.1, 0.9},
                                         GilbertElliottLoss{0.9, 0.8, 0, 1},
                                         GilbertElliottLoss{0.3, 1, 0, 1}),
                         [](const auto& test) { return "Chain" + std::to_string(test.index); });

TEST(LossProcessTest, ABurstIsNotWhatIndependentLossGives) {
  const auto mean_length = [](const LossModel& model) {
    const auto lengths = BurstLengths(Losses(model, 200'000));
    return std::accumulate(lengths.begin(), lengths.end(), 0.0) /
           static_cast<double>(lengths.size());
  };
  const double same_share = kBursts.good_to_bad / (kBursts.good_to_bad + kBursts.bad_to_good);
  EXPECT_GT(mean_length(LossModel(kBursts)),
            3 * mean_length(LossModel(IndependentLoss{same_share})));
}

class LossSpacingTest : public testing::TestWithParam<LossModel> {
 protected:
  static constexpr std::uint64_t kMessages = 5 * LossProcess::kBlock;
};

TEST_P(LossSpacingTest, TheFateOfAMessageDoesNotDependOnWhichOthersWereAskedFor) {
  const auto all = Losses(GetParam(), kMessages);
  for (const std::uint64_t step :
       {std::uint64_t{2}, std::uint64_t{7}, std::uint64_t{1000}, LossProcess::kBlock - 1,
        LossProcess::kBlock, LossProcess::kBlock + 1, 2 * LossProcess::kBlock + 5}) {
    LossProcess process = Process(GetParam());
    for (std::uint64_t n = step / 2; n < kMessages; n += step) {
      ASSERT_EQ(process.Loses(n), all[n]) << "message " << n << ", step " << step;
    }
  }
}

TEST_P(LossSpacingTest, TheFateOfAMessageDoesNotDependOnTheOrderOfTheQuestions) {
  const auto all = Losses(GetParam(), kMessages);
  LossProcess process = Process(GetParam());
  const Random random(11, RandomStream::kTest);
  for (std::uint64_t i = 0; i < 500; ++i) {
    const std::uint64_t n = random.Bits(i)[0] % kMessages;
    ASSERT_EQ(process.Loses(n), all[n]) << "message " << n;
    ASSERT_EQ(process.Loses(n), all[n]) << "asked twice, message " << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Models, LossSpacingTest,
                         testing::Values(LossModel(IndependentLoss{0.2}), LossModel(kBursts),
                                         LossModel(GilbertElliottLoss{0.01, 0.02, 0.1, 0.9}),
                                         LossModel(ScriptedLoss{
                                             {{3, 2}, {4095, 3}, {9000, 2000}}})),
                         [](const auto& test) { return "Model" + std::to_string(test.index); });

TEST(LossProcessTest, DependsOnTheSeed) {
  for (const LossModel& model : {LossModel(IndependentLoss{0.2}), LossModel(kBursts)}) {
    EXPECT_EQ(Losses(model, 5000, 1), Losses(model, 5000, 1));
    EXPECT_NE(Losses(model, 5000, 1), Losses(model, 5000, 2));
  }
}

TEST(LossProcessTest, AScriptLosesExactlyItsMessages) {
  constexpr std::uint64_t kLast = std::numeric_limits<std::uint64_t>::max() - 1;
  LossProcess process =
      Process(LossModel(ScriptedLoss{{{0, 1}, {5, 3}, {8, 1}, {20, 19}, {kLast, 1}}}));
  std::vector<std::uint64_t> lost;
  for (std::uint64_t n = 0; n < 100; ++n) {
    if (process.Loses(n)) lost.push_back(n);
  }
  std::vector<std::uint64_t> expected{0, 5, 6, 7, 8};
  for (std::uint64_t n = 20; n < 39; ++n) expected.push_back(n);
  EXPECT_EQ(lost, expected);
  EXPECT_FALSE(process.Loses(kLast - 1));
  EXPECT_TRUE(process.Loses(kLast));
  EXPECT_FALSE(process.Loses(kLast + 1));
}

TEST(LossProcessTest, ARepeatIsDrawnApartButMeetsTheSameBurst) {
  GilbertElliottLoss chain = kBursts;
  chain.loss_bad = 0.5;
  const auto bursts = Losses(LossModel(kBursts), 20'000);
  LossProcess process = Process(LossModel(chain));
  int in_burst = 0;
  int differ = 0;
  for (std::uint64_t n = 0; n < bursts.size(); ++n) {
    const bool first = process.Loses(n, 0);
    const bool second = process.Loses(n, 1);
    if (!bursts[n]) {
      ASSERT_FALSE(first || second) << n;
      continue;
    }
    ++in_burst;
    differ += first != second ? 1 : 0;
  }
  ASSERT_GT(in_burst, 1000);
  EXPECT_NEAR(differ, 0.5 * in_burst, 5 * 0.5 * std::sqrt(in_burst));
}

TEST(LossProcessTest, AScriptLosesEveryRepeatOfItsMessages) {
  LossProcess process = Process(LossModel(ScriptedLoss{{{3, 1}}}));
  EXPECT_TRUE(process.Loses(3, 0));
  EXPECT_TRUE(process.Loses(3, 1));
  EXPECT_FALSE(process.Loses(4, 1));
}

TEST(LossProcessTest, AsksWithoutAllocation) {
  for (const LossModel& model :
       {LossModel(IndependentLoss{0.2}), LossModel(kBursts), LossModel(ScriptedLoss{{{3, 500}}})}) {
    LossProcess process = Process(model);
    const test::RealtimeGuard guard;
    int lost = 0;
    for (std::uint64_t n = 0; n < 10'000; n += 3) lost += process.Loses(n) ? 1 : 0;
    const auto counts = guard.counts();
    EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
    EXPECT_GT(lost, 0);
  }
}

/// The text a loss is refused with; empty when it is accepted.
template <typename Parameters>
std::string RefusalOf(const Parameters& parameters) {
  try {
    const LossModel model(parameters);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(LossModelTest, RefusesProbabilitiesOutsideTheirRangeByName) {
  for (const double bad : {-0.01, 1.01, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(RefusalOf(IndependentLoss{bad}),
                AllOf(HasSubstr("loss: probability"), HasSubstr("[0, 1]")));
    EXPECT_THAT(RefusalOf(GilbertElliottLoss{bad, 1, 0, 1}), HasSubstr("loss: good_to_bad"));
    EXPECT_THAT(RefusalOf(GilbertElliottLoss{0, bad, 0, 1}), HasSubstr("loss: bad_to_good"));
    EXPECT_THAT(RefusalOf(GilbertElliottLoss{0, 1, bad, 1}), HasSubstr("loss: loss_good"));
    EXPECT_THAT(RefusalOf(GilbertElliottLoss{0, 1, 0, bad}), HasSubstr("loss: loss_bad"));
  }
  EXPECT_EQ(RefusalOf(GilbertElliottLoss{1, 1, 1, 1}), "");
}

TEST(LossModelTest, RefusesABurstWithoutEnd) {
  EXPECT_THAT(RefusalOf(GilbertElliottLoss{0.1, 0, 0, 1}), HasSubstr("bad_to_good"));
}

TEST(LossModelTest, RefusesAScriptThatIsEmptyFallingOrOverlapping) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  EXPECT_THAT(RefusalOf(ScriptedLoss{{{5, 0}}}), HasSubstr("runs[0].count"));
  EXPECT_THAT(RefusalOf(ScriptedLoss{{{5, 1}, {3, 1}}}), HasSubstr("runs[1].first is 3"));
  EXPECT_THAT(RefusalOf(ScriptedLoss{{{5, 3}, {7, 1}}}), HasSubstr("at least 8"));
  EXPECT_THAT(RefusalOf(ScriptedLoss{{{5, kMost}}}), HasSubstr("runs[0].count"));
  EXPECT_EQ(RefusalOf(ScriptedLoss{{{5, 3}, {8, 1}}}), "");
  EXPECT_EQ(RefusalOf(ScriptedLoss{}), "");
}

TEST(LossModelTest, GivesItsParametersBack) {
  const LossModel model(ScriptedLoss{{{5, 3}, {9, 1}}});
  const auto& runs = std::get<ScriptedLoss>(model.parameters()).runs;
  std::vector<std::uint64_t> figures;
  for (const auto& run : runs) figures.insert(figures.end(), {run.first, run.count});
  EXPECT_THAT(figures, ElementsAre(5, 3, 9, 1));
  EXPECT_EQ(std::get<IndependentLoss>(LossModel(IndependentLoss{0.25}).parameters()).probability,
            0.25);
}

}  // namespace
}  // namespace twin::faults::faults_loss_model_test

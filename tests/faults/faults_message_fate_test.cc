#include "twin/faults/message_fate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::faults::faults_message_fate_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr std::uint64_t kSeed = 3;
constexpr LogNormalDelay kDelay{
    .median = microseconds(200), .sigma = 0.5, .offset = microseconds(50)};

/// Everything at once.
DirectionConfig Rough() {
  DirectionConfig config;
  config.delay = DelayModel(kDelay);
  config.loss = LossModel(GilbertElliottLoss{0.02, 0.2, 0.01, 0.9});
  config.duplication = 0.1;
  config.duplicate_delay = DelayModel(kDelay);
  config.reordering = 0.2;
  config.reorder_by = milliseconds(3);
  return config;
}

std::vector<Fate> Fates(const DirectionConfig& config, std::uint64_t n, std::uint64_t seed = kSeed,
                        const FateStreams& streams = kStateStreams) {
  MessageFate fate(config, seed, streams);
  std::vector<Fate> fates(n);
  for (std::uint64_t i = 0; i < n; ++i) fates[i] = fate.Of(i);
  return fates;
}

TEST(MessageFateTest, EveryMessageArrivesAtOnceByDefault) {
  for (const Fate& fate : Fates(DirectionConfig(), 1000)) ASSERT_EQ(fate, Fate());
}

TEST(MessageFateTest, DelayAndIndependentLossAreTheDrawsOfTheirStreams) {
  DirectionConfig config;
  config.delay = DelayModel(kDelay);
  config.loss = LossModel(IndependentLoss{0.1});
  const auto fates = Fates(config, 1000, kSeed, kCommandStreams);
  const Random loss(kSeed, RandomStream::kCommandLoss);
  const Random delay(kSeed, RandomStream::kCommandDelay);
  for (std::uint64_t n = 0; n < fates.size(); ++n) {
    ASSERT_EQ(fates[n].lost, loss.Uniform(n) < 0.1);
    if (fates[n].lost) continue;
    ASSERT_EQ(fates[n].delay, config.delay.Draw(delay, n));
  }
}

TEST(MessageFateTest, HoldsBackTheGivenShareByTheGivenTimeAndLeavesTheRest) {
  constexpr std::uint64_t kMessages = 100'000;
  DirectionConfig config;
  config.delay = DelayModel(kDelay);
  const auto plain = Fates(config, kMessages);
  config.reordering = 0.2;
  config.reorder_by = milliseconds(3);
  const auto reordered = Fates(config, kMessages);
  double held = 0;
  for (std::uint64_t n = 0; n < kMessages; ++n) {
    const Duration more = reordered[n].delay - plain[n].delay;
    ASSERT_TRUE(more == Duration::zero() || more == milliseconds(3)) << more.count();
    held += more > Duration::zero() ? 1 : 0;
  }
  EXPECT_NEAR(held, 0.2 * kMessages, 5 * std::sqrt(0.2 * 0.8 * kMessages));
}

TEST(MessageFateTest, DuplicatesTheGivenShareAndLeavesTheFirstCopy) {
  constexpr std::uint64_t kMessages = 100'000;
  DirectionConfig config = Rough();
  const auto duplicated = Fates(config, kMessages);
  config.duplication = 0;
  const auto plain = Fates(config, kMessages);
  double arrived = 0;
  double copies = 0;
  for (std::uint64_t n = 0; n < kMessages; ++n) {
    ASSERT_EQ(duplicated[n].lost, plain[n].lost);
    ASSERT_EQ(duplicated[n].delay, plain[n].delay);
    ASSERT_FALSE(plain[n].duplicated);
    if (plain[n].lost) {
      ASSERT_EQ(duplicated[n], plain[n]) << "a lost message has no copy";
      continue;
    }
    ++arrived;
    copies += duplicated[n].duplicated ? 1 : 0;
  }
  EXPECT_NEAR(copies, 0.1 * arrived, 5 * std::sqrt(0.1 * 0.9 * arrived));
}

TEST(MessageFateTest, TheSecondCopyFollowsByADelayThatDoesNotDependOnTheDecisionToCopy) {
  DirectionConfig config;
  config.duplication = 0.05;
  config.duplicate_delay = DelayModel(kDelay);
  config.delay = DelayModel(ConstantDelay{milliseconds(1)});
  std::vector<Duration> behind;
  for (const Fate& fate : Fates(config, 100'000)) {
    if (fate.duplicated) behind.push_back(fate.duplicate_delay - fate.delay);
  }
  ASSERT_GT(behind.size(), 4000u);
  const auto below = std::count_if(behind.begin(), behind.end(),
                                   [](Duration d) { return d < kDelay.offset + kDelay.median; });
  const double n = static_cast<double>(behind.size());
  EXPECT_NEAR(static_cast<double>(below), n / 2, 5 * std::sqrt(n) / 2);
}

TEST(MessageFateTest, IsAFunctionOfSeedStreamsAndNumberInAnyOrder) {
  constexpr std::uint64_t kMessages = 10'000;
  const auto fates = Fates(Rough(), kMessages);
  MessageFate again(Rough(), kSeed, kStateStreams);
  for (std::uint64_t n = kMessages; n > 0; n -= 40) ASSERT_EQ(again.Of(n - 1), fates[n - 1]) << n;
  EXPECT_NE(fates, Fates(Rough(), kMessages, kSeed + 1));
  EXPECT_NE(fates, Fates(Rough(), kMessages, kSeed, kCommandStreams));
}

TEST(MessageFateTest, ARepeatDiffersInItsLossOnly) {
  MessageFate fate(Rough(), kSeed, kStateStreams);
  int lost_once = 0;
  for (std::uint64_t n = 0; n < 10'000; ++n) {
    const Fate first = fate.Of(n, 0);
    const Fate second = fate.Of(n, 1);
    if (first.lost != second.lost) {
      ++lost_once;
    } else {
      ASSERT_EQ(first, second) << n;
    }
  }
  EXPECT_GT(lost_once, 10);
}

TEST(MessageFateTest, AsksWithoutAllocation) {
  DirectionConfig config = Rough();
  config.delay = DelayModel(EmpiricalDelay{{microseconds(10), microseconds(20)}, {1}});
  MessageFate fate(config, kSeed, kStateStreams);
  const test::RealtimeGuard guard;
  Duration sum{};
  for (std::uint64_t n = 0; n < 10'000; ++n) sum += fate.Of(n).delay;
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_GT(sum, Duration::zero());
}

/// The text a direction is refused with; empty when it is accepted.
std::string RefusalOf(const DirectionConfig& config) {
  try {
    config.Validate("wire.up");
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(DirectionConfigTest, RefusesProbabilitiesOutsideTheirRangeByName) {
  for (const double bad : {-0.01, 1.01, std::numeric_limits<double>::quiet_NaN()}) {
    DirectionConfig config = Rough();
    config.duplication = bad;
    EXPECT_THAT(RefusalOf(config), HasSubstr("wire.up.duplication is "));
    config = Rough();
    config.reordering = bad;
    EXPECT_THAT(RefusalOf(config), HasSubstr("wire.up.reordering is "));
  }
  EXPECT_EQ(RefusalOf(Rough()), "");
  EXPECT_EQ(RefusalOf(DirectionConfig()), "");
}

TEST(DirectionConfigTest, RefusesAHoldBackThatIsNegativeOverlongOrWithoutEffect) {
  DirectionConfig config = Rough();
  for (const Duration bad : {Duration(-1), Duration::zero(), Duration(std::chrono::hours(2))}) {
    config.reorder_by = bad;
    EXPECT_THAT(RefusalOf(config), HasSubstr("wire.up.reorder_by is ")) << bad.count();
  }
}

TEST(MessageFateTest, RefusesADirectionThatIsNotValid) {
  DirectionConfig config;
  config.duplication = 2;
  EXPECT_THROW(MessageFate(config, kSeed, kStateStreams), InputError);
}

}  // namespace
}  // namespace twin::faults::faults_message_fate_test

#include "twin/teleop/wire.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "twin/core/error.h"
#include "twin/teleop/operator_sample.h"

namespace twin::teleop::teleop_wire_test {
namespace {

using std::chrono::milliseconds;

faults::DirectionConfig Delayed(Duration delay) {
  return {
      .delay = faults::DelayModel(faults::ConstantDelay{delay}), .loss = {}, .duplicate_delay = {}};
}

/// Sequences that are taken when one is sent every millisecond.
std::vector<std::uint64_t> Taken(const faults::DirectionConfig& config, int count,
                                 std::uint64_t seed = 1) {
  Wire<OperatorSample> wire(config, seed, kToRobotStreams);
  std::vector<std::uint64_t> taken;
  for (int i = 0; i < count; ++i) {
    const Time now{milliseconds(i)};
    wire.Send(now, {.sequence = static_cast<std::uint64_t>(i) + 1});
    if (const auto sample = wire.Take(now)) taken.push_back(sample->sequence);
  }
  return taken;
}

TEST(WireTest, DeliversAtOnceWithoutDelay) {
  EXPECT_EQ(Taken(Delayed({}), 3), (std::vector<std::uint64_t>{1, 2, 3}));
}

TEST(WireTest, DeliversAfterItsDelay) {
  Wire<OperatorSample> wire(Delayed(milliseconds(150)), 1, kToRobotStreams);
  wire.Send(Time{}, {.sequence = 1});
  EXPECT_FALSE(wire.Take(Time{milliseconds(149)}));
  EXPECT_TRUE(wire.Take(Time{milliseconds(150)}));
}

TEST(WireTest, GivesTheNewestOfThoseThatArrivedTogether) {
  Wire<OperatorSample> wire(Delayed(milliseconds(1)), 1, kToRobotStreams);
  for (std::uint64_t i = 1; i <= 5; ++i) wire.Send(Time{}, {.sequence = i});
  EXPECT_EQ(wire.Take(Time{milliseconds(9)})->sequence, 5U);
  EXPECT_FALSE(wire.Take(Time{milliseconds(10)}));
}

TEST(WireTest, NeverGivesAnOlderOneAfterANewerOne) {
  faults::DirectionConfig config = Delayed(milliseconds(20));
  config.reordering = 0.3;
  config.reorder_by = milliseconds(40);
  config.duplication = 0.2;
  config.duplicate_delay = faults::DelayModel(faults::ConstantDelay{milliseconds(30)});
  const auto taken = Taken(config, 2000);
  for (std::size_t i = 1; i < taken.size(); ++i) EXPECT_LT(taken[i - 1], taken[i]);
}

TEST(WireTest, LosesTheShareItIsToldTo) {
  faults::DirectionConfig config;
  config.loss = faults::LossModel(faults::IndependentLoss{0.1});
  const auto arrived = static_cast<double>(Taken(config, 20'000).size());
  EXPECT_NEAR(arrived / 20'000, 0.9, 4 * 0.0021);  // four standard deviations
}

TEST(WireTest, RepeatsWithItsSeed) {
  faults::DirectionConfig config;
  config.loss = faults::LossModel(faults::IndependentLoss{0.5});
  EXPECT_EQ(Taken(config, 500, 3), Taken(config, 500, 3));
  EXPECT_NE(Taken(config, 500, 3), Taken(config, 500, 4));
}

TEST(WireTest, RefusesAShareThatIsNone) {
  faults::DirectionConfig config;
  config.duplication = 2;
  EXPECT_THROW(Wire<OperatorSample>(config, 1, kToRobotStreams), InputError);
}

}  // namespace
}  // namespace twin::teleop::teleop_wire_test

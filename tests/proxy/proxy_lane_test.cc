#include "proxy/relay_direction.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"

namespace twin::proxy::proxy_lane_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// What left, and when, on the queue's time.
class Record final : public Output {
 public:
  explicit Record(const rt::EventQueue& events) : events_(events) { gone_.reserve(10'000); }
  bool Send(std::span<const std::byte> bytes) noexcept override {
    if (is_shut_) return false;
    std::uint64_t content = 0;
    std::memcpy(&content, bytes.data(), sizeof content);
    gone_.emplace_back(content, events_.Now().time_since_epoch());
    size_ = bytes.size();
    return true;
  }

  const rt::EventQueue& events_;
  std::vector<std::pair<std::uint64_t, Duration>> gone_;
  std::size_t size_ = 0;
  bool is_shut_ = false;
};

class LaneTest : public ::testing::Test {
 protected:
  LaneTest() {
    faults_.delay = faults::DelayModel(faults::GammaDelay{2, milliseconds(1), microseconds(50)});
    faults_.loss = faults::LossModel(faults::GilbertElliottLoss{0.05, 0.2, 0.02, 0.9});
    faults_.duplication = 0.2;
    faults_.duplicate_delay = faults::DelayModel(faults::ConstantDelay{microseconds(1700)});
    faults_.reordering = 0.1;
    faults_.reorder_by = microseconds(2500);
  }

  RelayDirection Make(std::uint64_t seed = 7) {
    return RelayDirection(faults_, seed, faults::kStateStreams, events_,
                          rt::EventOrder::kStateArrival, exit_);
  }
  /// `count` datagrams, 1 ms apart, whose content is their number; then all that is on the way.
  void Relay(RelayDirection& direction, std::uint64_t count) {
    for (std::uint64_t k = 0; k < count; ++k) {
      RunUntil(Time(milliseconds(k)));
      std::array<std::byte, 64> bytes{};
      std::memcpy(bytes.data(), &k, sizeof k);
      direction.Take(bytes);
    }
    while (events_.RunNext()) {
    }
  }
  void RunUntil(Time now) {
    while (events_.NextTime() && *events_.NextTime() <= now) events_.RunNext();
    events_.AdvanceTo(now);
  }

  faults::DirectionConfig faults_;
  rt::EventQueue events_;
  Record exit_{events_};
};

TEST_F(LaneTest, EachDatagramHasTheFateOfItsNumber) {
  RelayDirection direction = Make();
  Relay(direction, 1000);
  faults::MessageFate fates(faults_, 7, faults::kStateStreams);
  std::vector<std::pair<std::uint64_t, Duration>> expected;
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const faults::Fate fate = fates.Of(k);
    if (fate.lost) continue;
    expected.emplace_back(k, milliseconds(k) + fate.delay);
    if (fate.duplicated) expected.emplace_back(k, milliseconds(k) + fate.duplicate_delay);
  }
  auto gone = exit_.gone_;
  std::ranges::sort(gone);
  std::ranges::sort(expected);
  EXPECT_EQ(gone, expected);
}

TEST_F(LaneTest, CountsWhatBecameOfEach) {
  RelayDirection direction = Make();
  Relay(direction, 1000);
  faults::MessageFate fates(faults_, 7, faults::kStateStreams);
  DirectionCounts expected;
  expected.came = 1000;
  expected.relayed = exit_.gone_.size();
  for (std::uint64_t k = 0; k < 1000; ++k) {
    const faults::Fate fate = fates.Of(k);
    expected.lost += fate.lost ? 1 : 0;
    expected.delayed += fate.delay > Duration::zero() ? 1 : 0;
    expected.duplicated += fate.duplicated ? 1 : 0;
  }
  std::uint64_t newest = 0;
  for (const auto& [number, at] : exit_.gone_) {
    expected.reordered += number < newest ? 1 : 0;
    newest = std::max(newest, number);
  }
  EXPECT_GT(expected.reordered, 0u);
  EXPECT_GT(expected.lost, 0u);
  EXPECT_EQ(direction.counts(), expected);
}

TEST_F(LaneTest, AnotherSeedGivesOtherFates) {
  faults_ = {};
  faults_.loss = faults::LossModel(faults::IndependentLoss{0.5});
  const auto gone = [this](std::uint64_t seed) {
    RelayDirection direction = Make(seed);
    exit_.gone_.clear();
    for (std::uint64_t k = 0; k < 64; ++k) {
      std::array<std::byte, 8> bytes{};
      std::memcpy(bytes.data(), &k, sizeof k);
      direction.Take(bytes);
    }
    while (events_.RunNext()) {
    }
    return exit_.gone_;
  };
  EXPECT_EQ(gone(7), gone(7));
  EXPECT_NE(gone(7), gone(8));
}

TEST_F(LaneTest, WithoutFaultsAllGoOnAtOnceAndInOrder) {
  faults_ = {};
  RelayDirection direction = Make();
  Relay(direction, 50);
  ASSERT_EQ(exit_.gone_.size(), 50u);
  for (std::uint64_t k = 0; k < 50; ++k) {
    EXPECT_EQ(exit_.gone_[k], std::pair(k, Duration(milliseconds(k))));
  }
  EXPECT_EQ(direction.counts(), (DirectionCounts{.came = 50, .relayed = 50}));
  EXPECT_EQ(exit_.size_, 64u);
}

TEST_F(LaneTest, ADatagramThatIsTooLongIsDroppedAndHasItsNumberAllTheSame) {
  faults_ = {};
  faults_.loss = faults::LossModel(faults::ScriptedLoss{{{1, 1}}});
  RelayDirection direction = Make();
  const std::array<std::byte, kLongestPacket + 1> long_one{};
  direction.Take(long_one);
  direction.Take(std::span(long_one).first(kLongestPacket));  // number 1: lost
  direction.Take(std::span(long_one).first(kLongestPacket));
  while (events_.RunNext()) {
  }
  EXPECT_EQ(direction.counts(),
            (DirectionCounts{.came = 3, .relayed = 1, .lost = 1, .dropped = 1}));
  EXPECT_EQ(exit_.size_, kLongestPacket);
}

TEST_F(LaneTest, AFloodFillsItsRoomAndNoMore) {
  faults_ = {};
  faults_.delay = faults::DelayModel(faults::ConstantDelay{milliseconds(100)});
  faults_.duplication = 1;
  RelayDirection direction = Make();
  constexpr std::size_t kRoom = robot::Channel<Packet>::kCapacity;
  const std::array<std::byte, 8> bytes{};
  for (std::size_t i = 0; i < kRoom + 100; ++i) direction.Take(bytes);
  EXPECT_EQ(events_.pending(), RelayDirection::kMostEvents);
  EXPECT_EQ(direction.counts().lost, 100u);
  while (events_.RunNext()) {
  }
  EXPECT_EQ(direction.counts().relayed, 2 * kRoom);
}

TEST_F(LaneTest, WhatTheSystemDoesNotTakeIsCounted) {
  faults_ = {};
  RelayDirection direction = Make();
  exit_.is_shut_ = true;
  Relay(direction, 3);
  EXPECT_EQ(direction.counts(), (DirectionCounts{.came = 3, .dropped = 3}));
}

TEST_F(LaneTest, RelaysWithoutAllocationAndLocks) {
  RelayDirection direction = Make();
  const test::RealtimeGuard guard;
  Relay(direction, 1000);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::proxy::proxy_lane_test

#include "plugins/devices/operator_message.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

namespace twin::devices::devices_message_test {
namespace {

using Bytes = std::array<std::byte, kSampleBytes>;

SampleMessage Message() {
  SampleMessage message{.token = *TokenOf("secret"), .sample = {}};
  message.sample.sequence = 7;
  message.sample.at = Time(Duration(-5));
  message.sample.axes = {0.1, -0.2, 0.3, -0.4, 0.5, -1};
  message.sample.engaged = false;
  message.sample.mode_presses = 1;
  message.sample.gripper_presses = 2;
  message.sample.frame_presses = 3;
  message.sample.scale_presses = 4;
  message.sample.stop_presses = 5;
  message.sample.release_presses = 6;
  message.sample.end_presses = 0xFFFFFFFF;
  return message;
}

Bytes Written(const SampleMessage& message) {
  Bytes bytes;
  WriteSample(message, bytes);
  return bytes;
}

template <typename T>
T At(const Bytes& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, &bytes.at(offset), sizeof value);
  return value;
}

TEST(OperatorMessageTest, PutsEveryFieldWhereItsTableSays) {
  const Bytes bytes = Written(Message());
  EXPECT_EQ(std::memcmp(bytes.data(), "PTOS", 4), 0);
  EXPECT_EQ(At<std::uint16_t>(bytes, 4), 1);
  EXPECT_EQ(At<std::uint8_t>(bytes, 6), 0);
  EXPECT_EQ(At<std::uint8_t>(bytes, 7), 0);
  EXPECT_EQ(std::memcmp(&bytes[8], "secret\0\0\0\0\0\0\0\0\0\0", 16), 0);
  EXPECT_EQ(At<std::uint64_t>(bytes, 24), 7u);
  EXPECT_EQ(At<std::int64_t>(bytes, 32), -5);
  EXPECT_EQ(At<double>(bytes, 40), 0.1);
  EXPECT_EQ(At<double>(bytes, 80), -1);
  EXPECT_EQ(At<std::uint32_t>(bytes, 88), 1u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 92), 2u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 96), 3u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 100), 4u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 104), 5u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 108), 6u);
  EXPECT_EQ(At<std::uint32_t>(bytes, 112), 0xFFFFFFFFu);
}

TEST(OperatorMessageTest, ReadsWhatItWrote) {
  const Bytes bytes = Written(Message());
  const auto read = ParseSample(bytes);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(Written(*read), bytes);
}

TEST(OperatorMessageTest, RefusesEveryOtherLength) {
  std::array<std::byte, kSampleBytes + 1> longer{};
  std::ranges::copy(Written(Message()), longer.begin());
  for (std::size_t size = 0; size <= longer.size(); ++size) {
    EXPECT_EQ(ParseSample(std::span(longer).first(size)).has_value(), size == kSampleBytes);
  }
}

/// Whether a sample is read in which the value at an offset is another.
template <typename T>
bool IsReadWith(std::size_t offset, T value, SampleMessage message = Message()) {
  Bytes bytes = Written(message);
  std::memcpy(&bytes.at(offset), &value, sizeof value);
  return ParseSample(bytes).has_value();
}

TEST(OperatorMessageTest, RefusesAnotherMagic) {
  EXPECT_FALSE(IsReadWith(3, 'X'));
}

TEST(OperatorMessageTest, RefusesAnotherVersion) {
  EXPECT_FALSE(IsReadWith(4, std::uint16_t{2}));
}

TEST(OperatorMessageTest, RefusesKindsAndFlagsThatAreNone) {
  EXPECT_TRUE(IsReadWith(6, std::uint8_t{1}));
  EXPECT_FALSE(IsReadWith(6, std::uint8_t{2}));
  EXPECT_FALSE(IsReadWith(7, std::uint8_t{2}));
}

TEST(OperatorMessageTest, RefusesSequencesOutOfRange) {
  EXPECT_FALSE(IsReadWith(24, std::uint64_t{0}));
  EXPECT_TRUE(IsReadWith(24, kMostSequence));
  EXPECT_FALSE(IsReadWith(24, kMostSequence + 1));
}

TEST(OperatorMessageTest, RefusesDeflectionsBeyondFullScale) {
  EXPECT_TRUE(IsReadWith(40, 1.0));
  EXPECT_FALSE(IsReadWith(40, std::nextafter(1.0, 2.0)));
  EXPECT_FALSE(IsReadWith(80, -1.5));
}

TEST(OperatorMessageTest, RefusesHandlesOutOfReach) {
  SampleMessage message = Message();
  message.sample.kind = teleop::AxisKind::kPose;
  EXPECT_TRUE(IsReadWith(40, 9.5, message));
  EXPECT_FALSE(IsReadWith(40, 10.5, message));
}

TEST(OperatorMessageTest, RefusesAxesThatAreNoNumbers) {
  EXPECT_FALSE(IsReadWith(48, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(IsReadWith(48, std::numeric_limits<double>::infinity()));
}

TEST(OperatorMessageTest, ReadsTheFeedbackItWrote) {
  const teleop::OperatorFeedback feedback{.sequence = 3,
                                          .echo = 2,
                                          .wrench = {1, 2, 3, 4, 5, 6},
                                          .mode = teleop::Mode::kBase,
                                          .stopped = true,
                                          .holding = false,
                                          .hand_closed = true,
                                          .fine = false,
                                          .at_border = true};
  std::array<std::byte, kFeedbackBytes> bytes;
  WriteFeedback(feedback, bytes);
  const auto read = ParseFeedback(bytes);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->sequence, 3u);
  EXPECT_EQ(read->echo, 2u);
  EXPECT_EQ(read->wrench, feedback.wrench);
  EXPECT_EQ(read->mode, teleop::Mode::kBase);
  EXPECT_TRUE(read->stopped);
  EXPECT_FALSE(read->holding);
  EXPECT_TRUE(read->hand_closed);
  EXPECT_FALSE(read->fine);
  EXPECT_TRUE(read->at_border);
}

TEST(OperatorMessageTest, RefusesFeedbackWithFlagsThatAreNone) {
  std::array<std::byte, kFeedbackBytes> bytes;
  WriteFeedback({}, bytes);
  ASSERT_TRUE(ParseFeedback(bytes).has_value());
  bytes[7] = std::byte{32};
  EXPECT_FALSE(ParseFeedback(bytes).has_value());
}

TEST(TokenTest, IsOneToSixteenPrintableCharacters) {
  EXPECT_TRUE(TokenOf("0123456789abcdef").has_value());
  EXPECT_FALSE(TokenOf("").has_value());
  EXPECT_FALSE(TokenOf("0123456789abcdefg").has_value());
  EXPECT_FALSE(TokenOf("a\tb").has_value());
}

}  // namespace
}  // namespace twin::devices::devices_message_test

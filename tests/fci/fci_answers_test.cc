#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "fci/byte_packer.h"
#include "fci/random_messages.h"
#include "twin/fci/requests.h"

namespace twin::fci::fci_answers_test {
namespace {

using testing::HasSubstr;

/// A frame with this payload and a head that does not matter to a client.
Frame FrameWith(const Bytes& payload) {
  return {{99, 1, 0}, payload};
}

Bytes PayloadOf(const Bytes& frame, std::size_t head) {
  return {frame.begin() + static_cast<std::ptrdiff_t>(head), frame.end()};
}

template <typename Answer>
std::string WhatIsBad(const std::variant<Answer, BadFrame>& parsed) {
  const auto* bad = std::get_if<BadFrame>(&parsed);
  return bad == nullptr ? "nothing" : bad->what;
}

TEST(ArmAnswerTest, IsAHeadAndAStatus) {
  for (std::uint32_t command = 0; command < kArmCommands; ++command) {
    for (const int status : {0, 1, 9, 255}) {
      const Bytes frame =
          EncodeArmAnswer(static_cast<ArmCommand>(command), 77, static_cast<std::uint8_t>(status));
      BytePacker packer;
      packer.Put(command).Put(std::uint32_t{77}).Put(std::uint32_t{13});
      EXPECT_EQ(frame, packer.Put(static_cast<std::uint8_t>(status)).bytes());
    }
  }
}

TEST(ArmAnswerTest, ComesBackWithItsStatus) {
  for (std::uint32_t command = 0; command < kArmCommands; ++command) {
    const auto asked = static_cast<ArmCommand>(command);
    if (asked == ArmCommand::kConnect || asked == ArmCommand::kGetCartesianLimit) continue;
    for (int status = 0; status < 256; ++status) {
      const Bytes payload =
          PayloadOf(EncodeArmAnswer(asked, 1, static_cast<std::uint8_t>(status)), 12);
      const auto answer = ParseArmAnswer(asked, FrameWith(payload));
      ASSERT_EQ(WhatIsBad(answer), "nothing");
      EXPECT_EQ(std::get<ArmAnswer>(answer).status, status);
    }
  }
}

TEST(ArmAnswerTest, TellsTheServersVersion) {
  const Bytes frame = EncodeArmConnectAnswer(3, ConnectStatus::kIncompatibleLibraryVersion, 0xA1B2);
  const Bytes payload = PayloadOf(frame, 12);
  const auto answer = ParseArmAnswer(ArmCommand::kConnect, FrameWith(payload));
  ASSERT_EQ(WhatIsBad(answer), "nothing");
  EXPECT_EQ(std::get<ArmAnswer>(answer).status, 1);
  EXPECT_EQ(std::get<ArmAnswer>(answer).version, 0xA1B2);
}

TEST(ArmAnswerTest, TellsAVirtualWall) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    RandomMessages random(seed);
    CartesianLimit limit;
    random.Fill(limit.object_world_size, limit.object_frame, limit.object_activation);
    BytePacker expected;
    expected.Put(std::uint32_t{3}).Put(std::uint32_t{5}).Put(std::uint32_t{166});
    expected.Put(std::uint8_t{2}).Put(limit.object_world_size).Put(limit.object_frame);
    expected.Put(limit.object_activation);
    const Bytes frame =
        EncodeCartesianLimitAnswer(5, SetterStatus::kInvalidArgumentRejected, limit);
    ASSERT_EQ(frame, expected.bytes());

    const Bytes payload = PayloadOf(frame, 12);
    const auto answer = ParseArmAnswer(ArmCommand::kGetCartesianLimit, FrameWith(payload));
    ASSERT_EQ(WhatIsBad(answer), "nothing");
    const ArmAnswer& told = std::get<ArmAnswer>(answer);
    EXPECT_EQ(told.status, 2);
    EXPECT_EQ(told.limit.object_world_size, limit.object_world_size);
    EXPECT_EQ(told.limit.object_frame, limit.object_frame);
    EXPECT_EQ(told.limit.object_activation, limit.object_activation);
  }
}

TEST(ArmAnswerTest, BringsTheModelLibrary) {
  for (const std::size_t size : {0, 1, 1000, 100'000}) {
    Bytes library(size);
    for (std::size_t i = 0; i < size; ++i) library[i] = static_cast<std::byte>(i * 7);
    const Bytes frame = EncodeModelLibraryAnswer(9, ModelLibraryStatus::kSuccess, library);
    ASSERT_EQ(frame.size(), 13 + size);
    const Bytes payload = PayloadOf(frame, 12);
    const auto answer = ParseArmAnswer(ArmCommand::kLoadModelLibrary, FrameWith(payload));
    ASSERT_EQ(WhatIsBad(answer), "nothing");
    EXPECT_EQ(ToBytes(std::get<ArmAnswer>(answer).library), library);
  }
  EXPECT_EQ(EncodeModelLibraryAnswer(9, ModelLibraryStatus::kError, {}),
            Hex("0d000000 09000000 0d000000 01"));
}

TEST(ArmAnswerTest, IsRefusedWhenAnyByteIsMissingAndTakenWithMore) {
  for (std::uint32_t command = 0; command < kArmCommands; ++command) {
    const auto asked = static_cast<ArmCommand>(command);
    std::size_t needed = 1;
    if (asked == ArmCommand::kConnect) needed = 3;
    if (asked == ArmCommand::kGetCartesianLimit) needed = 154;
    for (std::size_t size = 0; size < 200; ++size) {
      const Bytes payload(size, std::byte{1});
      const std::string what = WhatIsBad(ParseArmAnswer(asked, FrameWith(payload)));
      const std::string short_of = std::string(Name(asked)) + ": an answer with " +
                                   std::to_string(size) + " bytes of payload, " +
                                   std::to_string(needed) + " are needed";
      ASSERT_EQ(what, size < needed ? short_of : "nothing");
    }
  }
}

TEST(ArmAnswerTest, HasNoFlagButZeroAndOne) {
  for (int flag = 0; flag < 256; ++flag) {
    Bytes payload(154);
    payload[153] = static_cast<std::byte>(flag);
    const auto answer = ParseArmAnswer(ArmCommand::kGetCartesianLimit, FrameWith(payload));
    ASSERT_EQ(WhatIsBad(answer),
              flag <= 1 ? "nothing" : "Get Cartesian Limit: a flag is neither 0 nor 1");
  }
}

TEST(HandAnswerTest, IsAHeadAndAStatusOfTwoBytes) {
  const std::pair<HandResult, std::uint16_t> numbers[] = {{HandResult::kSuccess, 0},
                                                          {HandResult::kFail, 1},
                                                          {HandResult::kUnsuccessful, 2},
                                                          {HandResult::kAborted, 3}};
  for (std::uint16_t command = 1; command < kHandCommands; ++command) {
    const auto asked = static_cast<HandCommandId>(command);
    for (const auto& [result, number] : numbers) {
      const Bytes frame = EncodeHandAnswer(asked, 0x01020304, result);
      BytePacker packer;
      packer.Put(command).Put(std::uint32_t{0x01020304}).Put(std::uint32_t{12}).Put(number);
      EXPECT_EQ(frame, packer.bytes());
      const Bytes payload = PayloadOf(frame, 10);
      const auto answer = ParseHandAnswer(asked, FrameWith(payload));
      ASSERT_EQ(WhatIsBad(answer), "nothing");
      EXPECT_EQ(std::get<HandAnswer>(answer).result, result);
    }
  }
}

TEST(HandAnswerTest, TellsTheServersVersion) {
  const Bytes frame = EncodeHandConnectAnswer(0, ConnectStatus::kIncompatibleLibraryVersion, 4);
  EXPECT_EQ(frame, Hex("0000 00000000 0e000000 0100 0400"));
  const Bytes payload = PayloadOf(frame, 10);
  const auto answer = ParseHandAnswer(HandCommandId::kConnect, FrameWith(payload));
  ASSERT_EQ(WhatIsBad(answer), "nothing");
  EXPECT_EQ(std::get<HandAnswer>(answer).result, HandResult::kFail);
  EXPECT_EQ(std::get<HandAnswer>(answer).version, 4);
}

TEST(HandAnswerTest, HasNoStatusButThoseThatExist) {
  for (std::uint16_t command = 0; command < kHandCommands; ++command) {
    const auto asked = static_cast<HandCommandId>(command);
    const int last = asked == HandCommandId::kConnect ? 1 : 3;
    for (const int status : {0, 1, 2, 3, 4, 255, 256, 65535}) {
      BytePacker payload;
      payload.Put(static_cast<std::uint16_t>(status)).Put(std::uint16_t{3});
      const std::string what = WhatIsBad(ParseHandAnswer(asked, FrameWith(payload.bytes())));
      if (status <= last) {
        EXPECT_EQ(what, "nothing");
      } else {
        EXPECT_THAT(what, HasSubstr("status " + std::to_string(status)));
        EXPECT_THAT(what, HasSubstr(std::string(Name(asked))));
      }
    }
  }
}

TEST(HandAnswerTest, IsRefusedWhenAnyByteIsMissingAndTakenWithMore) {
  for (std::uint16_t command = 0; command < kHandCommands; ++command) {
    const auto asked = static_cast<HandCommandId>(command);
    const std::size_t needed = asked == HandCommandId::kConnect ? 4 : 2;
    for (std::size_t size = 0; size < 20; ++size) {
      const Bytes payload(size);
      const std::string what = WhatIsBad(ParseHandAnswer(asked, FrameWith(payload)));
      if (size < needed) {
        EXPECT_THAT(what, HasSubstr(std::to_string(size) + " bytes of payload"));
      } else {
        EXPECT_EQ(what, "nothing");
      }
    }
  }
}

}  // namespace
}  // namespace twin::fci::fci_answers_test

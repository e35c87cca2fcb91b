#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "fci/byte_packer.h"
#include "twin/core/random.h"
#include "twin/fci/frame_reader.h"

namespace twin::fci::fci_frame_reader_test {
namespace {

using testing::HasSubstr;

constexpr std::size_t kLargest = 40;

/// A frame as it was sent or as it was read: command, id, payload.
using Sent = std::tuple<std::uint32_t, std::uint32_t, Bytes>;

std::size_t HeadOf(HeadKind kind) {
  return kind == HeadKind::kArm ? 12 : 10;
}

Bytes Head(HeadKind kind, std::uint32_t command, std::uint32_t id, std::uint32_t size) {
  BytePacker packer;
  if (kind == HeadKind::kArm) {
    packer.Put(command);
  } else {
    packer.Put(static_cast<std::uint16_t>(command));
  }
  return packer.Put(id).Put(size).bytes();
}

void Append(Bytes& stream, const Bytes& more) {
  stream.insert(stream.end(), more.begin(), more.end());
}

/// Frames of all sizes up to the largest, an empty payload among them.
std::vector<Sent> SomeFrames(HeadKind kind) {
  std::vector<Sent> frames;
  for (const std::size_t size : {0, 1, 3, 0, 17, static_cast<int>(kLargest - HeadOf(kind)), 2}) {
    Bytes payload;
    for (std::size_t i = 0; i < size; ++i) payload.push_back(static_cast<std::byte>(i + size));
    const auto number = static_cast<std::uint32_t>(frames.size());
    frames.emplace_back(number, 1000 * number, payload);
  }
  return frames;
}

Bytes StreamOf(HeadKind kind, const std::vector<Sent>& frames) {
  Bytes stream;
  for (const auto& [command, id, payload] : frames) {
    const std::size_t size = HeadOf(kind) + payload.size();
    Append(stream, Head(kind, command, id, static_cast<std::uint32_t>(size)));
    Append(stream, payload);
  }
  return stream;
}

/// Gives the reader bytes as a socket does: as many as there are and it has room for.
class Feeder {
 public:
  explicit Feeder(FrameReader& reader) : reader_(reader) {}

  /// @returns false when the reader took not all.
  bool Feed(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const auto room = reader_.Room();
      if (room.empty()) return false;
      const std::size_t count = std::min(room.size(), bytes.size());
      std::copy_n(bytes.begin(), count, room.begin());
      reader_.Received(count);
      bytes = bytes.subspan(count);
      Drain();
    }
    return true;
  }
  [[nodiscard]] const std::vector<Sent>& frames() const { return frames_; }

 private:
  void Drain() {
    while (const auto frame = reader_.Next()) {
      frames_.emplace_back(frame->head.command, frame->head.command_id, ToBytes(frame->payload));
    }
  }

  FrameReader& reader_;
  std::vector<Sent> frames_;
};

class FrameReaderTest : public testing::TestWithParam<HeadKind> {};
INSTANTIATE_TEST_SUITE_P(Both, FrameReaderTest, testing::Values(HeadKind::kArm, HeadKind::kHand));

TEST_P(FrameReaderTest, ReadsAStreamHoweverItIsSplitInThree) {
  const auto frames = SomeFrames(GetParam());
  const Bytes stream = StreamOf(GetParam(), frames);
  const std::span<const std::byte> all(stream);
  for (std::size_t first = 0; first <= stream.size(); ++first) {
    for (std::size_t second = first; second <= stream.size(); ++second) {
      FrameReader reader(GetParam(), kLargest);
      Feeder feeder(reader);
      ASSERT_TRUE(feeder.Feed(all.first(first)));
      ASSERT_TRUE(feeder.Feed(all.subspan(first, second - first)));
      ASSERT_TRUE(feeder.Feed(all.subspan(second)));
      ASSERT_EQ(feeder.frames(), frames) << first << " " << second;
      ASSERT_FALSE(reader.is_inside_frame());
      ASSERT_EQ(reader.fault(), nullptr);
    }
  }
}

TEST_P(FrameReaderTest, ReadsAStreamByteByByte) {
  const auto frames = SomeFrames(GetParam());
  FrameReader reader(GetParam(), kLargest);
  Feeder feeder(reader);
  for (const std::byte one : StreamOf(GetParam(), frames)) ASSERT_TRUE(feeder.Feed({&one, 1}));
  EXPECT_EQ(feeder.frames(), frames);
}

TEST_P(FrameReaderTest, ReadsMuchMoreThanItKeeps) {
  std::vector<Sent> frames;
  for (int i = 0; i < 300; ++i) {
    const auto some = SomeFrames(GetParam());
    frames.insert(frames.end(), some.begin(), some.end());
  }
  FrameReader reader(GetParam(), kLargest);
  Feeder feeder(reader);
  ASSERT_TRUE(feeder.Feed(StreamOf(GetParam(), frames)));
  EXPECT_EQ(feeder.frames(), frames);
}

TEST_P(FrameReaderTest, HandsOutAFrameOnlyWhenItIsWhole) {
  const Bytes stream = StreamOf(GetParam(), {{3, 4, Bytes(9)}});
  FrameReader reader(GetParam(), kLargest);
  EXPECT_FALSE(reader.is_inside_frame());
  for (std::size_t i = 0; i < stream.size(); ++i) {
    EXPECT_FALSE(reader.Next().has_value());
    reader.Room()[0] = stream[i];
    reader.Received(1);
    EXPECT_TRUE(reader.is_inside_frame());
  }
  EXPECT_TRUE(reader.Next().has_value());
  EXPECT_FALSE(reader.Next().has_value());
  EXPECT_FALSE(reader.is_inside_frame());
}

TEST_P(FrameReaderTest, TellsHeadAndPayload) {
  FrameReader reader(GetParam(), kLargest);
  Feeder feeder(reader);
  const std::vector<Sent> frames{{2, 0xFFFFFFFE, Bytes{std::byte{7}, std::byte{8}}}};
  ASSERT_TRUE(feeder.Feed(StreamOf(GetParam(), frames)));
  EXPECT_EQ(feeder.frames(), frames);
}

TEST_P(FrameReaderTest, AFramesBytesAreThoseThatCame) {
  const Bytes stream = StreamOf(GetParam(), {{0xABCD, 0xFFFFFFFE, Bytes{std::byte{7}}}});
  FrameReader reader(GetParam(), kLargest);
  std::ranges::copy(stream, reader.Room().begin());
  reader.Received(stream.size());
  const auto frame = reader.Next();
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(BytesOf(GetParam(), *frame), stream);
}

TEST_P(FrameReaderTest, AlwaysHasRoomUnlessAFrameWaits) {
  const std::size_t head = HeadOf(GetParam());
  FrameReader reader(GetParam(), kLargest);
  const Bytes stream = StreamOf(GetParam(), {{1, 1, Bytes(kLargest - head)}});
  for (const std::byte one : stream) {
    ASSERT_FALSE(reader.Room().empty());
    reader.Room()[0] = one;
    reader.Received(1);
  }
  EXPECT_TRUE(reader.Room().empty());
  EXPECT_TRUE(reader.Next().has_value());
  EXPECT_EQ(reader.Room().size(), kLargest);
}

TEST_P(FrameReaderTest, EndsTheStreamAtASizeThatNoFrameHas) {
  const auto head = static_cast<std::uint32_t>(HeadOf(GetParam()));
  const std::uint32_t largest = kLargest;
  for (const std::uint32_t size : {0U, 1U, head - 1, largest + 1, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
    FrameReader reader(GetParam(), kLargest);
    Feeder feeder(reader);
    const std::vector<Sent> good{{1, 2, Bytes(3)}};
    Bytes stream = StreamOf(GetParam(), good);
    Append(stream, Head(GetParam(), 7, 8, size));
    EXPECT_TRUE(feeder.Feed(stream));
    EXPECT_EQ(feeder.frames(), good);
    ASSERT_NE(reader.fault(), nullptr) << size;
    EXPECT_THAT(*reader.fault(), HasSubstr(std::to_string(size) + " bytes"));
    EXPECT_THAT(*reader.fault(), HasSubstr("command 7, id 8"));
    EXPECT_THAT(*reader.fault(),
                HasSubstr(std::to_string(head) + " to " + std::to_string(largest)));
    EXPECT_TRUE(reader.Room().empty());
    EXPECT_FALSE(feeder.Feed(StreamOf(GetParam(), good)));
    EXPECT_EQ(feeder.frames(), good);
  }
}

TEST_P(FrameReaderTest, TakesTheSmallestAndTheLargestFrame) {
  const std::size_t head = HeadOf(GetParam());
  for (const std::size_t payload : {std::size_t{0}, kLargest - head}) {
    FrameReader reader(GetParam(), kLargest);
    Feeder feeder(reader);
    ASSERT_TRUE(feeder.Feed(StreamOf(GetParam(), {{0, 0, Bytes(payload)}})));
    EXPECT_EQ(feeder.frames().size(), 1U);
    EXPECT_EQ(reader.fault(), nullptr);
  }
}

/// Whatever comes in whatever pieces: it ends or it is waited for, and every frame has its size.
TEST_P(FrameReaderTest, SurvivesAnyBytes) {
  const Random random(7, RandomStream::kTest);
  for (std::uint64_t round = 0; round < 2000; ++round) {
    FrameReader reader(GetParam(), kLargest);
    Feeder feeder(reader);
    for (std::uint32_t piece = 0; piece < 8; ++piece) {
      Bytes bytes;
      const auto bits = random.Bits(round, 100 * piece);
      for (std::uint32_t i = 0; i < bits[0] % 30; ++i) {
        // Small numbers mostly, so that sizes are found in them.
        const std::uint32_t value = random.Bits(round, 100 * piece + 1 + i)[0];
        bytes.push_back(static_cast<std::byte>(value % 5 == 0 ? value >> 8 & 0x1F : 0));
      }
      if (!feeder.Feed(bytes)) break;
    }
    for (const Sent& frame : feeder.frames()) {
      ASSERT_LE(std::get<Bytes>(frame).size(), kLargest - HeadOf(GetParam()));
    }
  }
}

}  // namespace
}  // namespace twin::fci::fci_frame_reader_test

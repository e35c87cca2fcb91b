#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/record/pcapng_reader.h"
#include "twin/record/pcapng_writer.h"

namespace twin::record::record_pcapng_test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr PacketEnd kRobot{.address = 0x7f000001, .port = 1337};
constexpr PacketEnd kClient{.address = 0x7f000001, .port = 40000};

Bytes Pattern(std::size_t size, unsigned seed) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = std::byte((seed + 7 * i) & 0xff);
  return bytes;
}

/// A packet and its bytes.
struct Kept {
  Packet packet;
  Bytes bytes;
};

std::vector<Kept> ReadAll(PcapngReader& reader) {
  std::vector<Kept> all;
  while (const auto packet = reader.Next()) {
    all.push_back({*packet, Bytes(packet->bytes.begin(), packet->bytes.end())});
  }
  return all;
}

class PcapngTest : public ::testing::Test {
 protected:
  /// A state, a request cut in two, a command.
  Bytes WriteSample() {
    const auto path = folder_.path() / "sample.pcapng";
    PcapngWriter writer(path);
    const Bytes state = Pattern(2373, 1);
    const Bytes request = Pattern(20000, 2);
    const Bytes command = Pattern(371, 3);
    writer.Add({.at = Time(Duration(5)), .from = kRobot, .to = kClient, .bytes = state});
    writer.Add({.at = Time(std::chrono::hours(30)),
                .transport = Transport::kTcp,
                .from = kClient,
                .to = kRobot,
                .bytes = request});
    writer.Add({.at = Time(Duration(9)), .from = kClient, .to = kRobot, .bytes = command});
    writer.Finish();
    return ReadBytes(path);
  }

  TemporaryFolder folder_;
};

TEST_F(PcapngTest, ReadsBackWhatWasWritten) {
  PcapngReader reader(WriteSample());
  const auto all = ReadAll(reader);
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].bytes, Pattern(2373, 1));
  EXPECT_EQ(all[0].packet.at, Time(Duration(5)));
  EXPECT_EQ(all[0].packet.transport, Transport::kUdp);
  EXPECT_EQ(all[0].packet.from, kRobot);
  EXPECT_EQ(all[0].packet.to, kClient);
  Bytes request = all[1].bytes;
  request.insert(request.end(), all[2].bytes.begin(), all[2].bytes.end());
  EXPECT_EQ(request, Pattern(20000, 2)) << "two segments of one stream";
  EXPECT_EQ(all[1].packet.at, Time(std::chrono::hours(30)));
  EXPECT_EQ(all[2].packet.transport, Transport::kTcp);
  EXPECT_EQ(all[3].bytes, Pattern(371, 3));
  EXPECT_EQ(reader.passed_over(), 0u);
  EXPECT_FALSE(reader.truncated());
}

TEST_F(PcapngTest, TheSamePacketsGiveTheSameBytes) {
  EXPECT_EQ(WriteSample(), WriteSample());
}

/// RFC 1071: the sum of all words, the checksum among them, is 0xffff.
std::uint32_t OnesComplementSum(const std::byte* begin, std::size_t size, std::uint32_t sum) {
  for (std::size_t i = 0; i < size; ++i) {
    sum += std::to_integer<std::uint32_t>(begin[i]) << (i % 2 == 0 ? 8 : 0);
  }
  while (sum >> 16 != 0) sum = (sum & 0xffff) + (sum >> 16);
  return sum;
}

TEST_F(PcapngTest, HeadsCarryTheChecksumsThatReceiversAskFor) {
  const Bytes file = WriteSample();
  // Section (28 bytes), interface (28 + 4 padding of its options), first packet (28 + heads).
  std::size_t at = 0;
  int packets = 0;
  while (at < file.size()) {
    const auto word = [&](std::size_t offset) {
      return std::to_integer<std::uint32_t>(file[at + offset]) |
             std::to_integer<std::uint32_t>(file[at + offset + 1]) << 8 |
             std::to_integer<std::uint32_t>(file[at + offset + 2]) << 16;
    };
    const std::uint32_t length = word(4);
    ASSERT_EQ(length % 4, 0u);
    if (word(0) == 6) {
      ++packets;
      const std::byte* ip = &file[at + 28];
      EXPECT_EQ(OnesComplementSum(ip, 20, 0), 0xffffu);
      if (ip[9] == std::byte{6}) {
        const std::uint32_t captured = word(20);
        const std::uint32_t pseudo = OnesComplementSum(ip + 12, 8, 6 + captured - 20);
        EXPECT_EQ(OnesComplementSum(ip + 20, captured - 20, pseudo), 0xffffu);
      }
    }
    at += length;
  }
  EXPECT_EQ(at, file.size());
  EXPECT_EQ(packets, 4);
}

TEST_F(PcapngTest, AKilledWritersFileIsReadUpToItsLastWholePacket) {
  Bytes file = WriteSample();
  file.resize(file.size() - 10);
  PcapngReader reader(file);
  EXPECT_EQ(ReadAll(reader).size(), 3u);
  EXPECT_TRUE(reader.truncated());
}

/// A file as tcpdump writes it: an interface of kind `link`, then packets.
class Capture {
 public:
  explicit Capture(std::uint16_t link) {
    Block(0x0a0d0d0a, [&] {
      Little(0x1a2b3c4d, 4);
      Little(1, 4);
      Little(0xffffffff, 4);
      Little(0xffffffff, 4);
    });
    Block(1, [&] {
      Little(link, 4);
      Little(0, 4);
    });
  }
  void Add(const Bytes& packet) {
    Block(6, [&] {
      Little(0, 4);
      Little(0, 4);
      Little(3, 4);  // microseconds
      Little(packet.size(), 4);
      Little(packet.size(), 4);
      bytes.insert(bytes.end(), packet.begin(), packet.end());
      while (bytes.size() % 4 != 0) bytes.push_back(std::byte{0});
    });
  }
  Bytes bytes;

 private:
  void Little(std::uint64_t x, int count) {
    for (int i = 0; i < count; ++i) bytes.push_back(std::byte((x >> (8 * i)) & 0xff));
  }
  template <typename Body>
  void Block(std::uint32_t kind, Body body) {
    Bytes before;
    std::swap(before, bytes);
    body();
    Bytes inside;
    std::swap(inside, bytes);
    bytes = before;
    Little(kind, 4);
    Little(inside.size() + 12, 4);
    bytes.insert(bytes.end(), inside.begin(), inside.end());
    Little(inside.size() + 12, 4);
  }
};

Bytes Concatenate(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

Bytes BigEndian(std::initializer_list<std::uint16_t> words) {
  Bytes bytes;
  for (const std::uint16_t word : words) {
    bytes.push_back(std::byte(word >> 8));
    bytes.push_back(std::byte(word & 0xff));
  }
  return bytes;
}

/// @param flags  IPv4's word of flags and fragment offset.
Bytes Ip(std::uint8_t protocol, std::uint16_t flags, const Bytes& body) {
  return Concatenate(
      {BigEndian({0x4500, static_cast<std::uint16_t>(20 + body.size()), 77, flags,
                  static_cast<std::uint16_t>(0x4000 | protocol), 0, 0xc0a8, 1, 0xc0a8, 2}),
       body});
}

Bytes Udp(const Bytes& data) {
  return Concatenate(
      {BigEndian({1337, 40000, static_cast<std::uint16_t>(8 + data.size()), 0}), data});
}

Bytes Tcp(std::uint16_t sequence, std::uint8_t flags, const Bytes& data) {
  return Concatenate({BigEndian({40000, 1337, 0, sequence, 0, 0,
                                 static_cast<std::uint16_t>(0x5000 | flags), 0xffff, 0, 0}),
                      data});
}

TEST_F(PcapngTest, PutsTheFragmentsOfAStateTogetherInWhateverOrderTheyCome) {
  const Bytes state = Pattern(2373, 5);
  const Bytes datagram = Udp(state);
  const Bytes first(datagram.begin(), datagram.begin() + 1480);
  const Bytes second(datagram.begin() + 1480, datagram.end());
  const Bytes ethernet = Concatenate({Bytes(12), BigEndian({0x0800})});
  for (const bool in_order : {true, false}) {
    Capture capture(1);
    const Bytes a = Concatenate({ethernet, Ip(17, 0x2000, first)});
    const Bytes b = Concatenate({ethernet, Ip(17, 1480 / 8, second)});
    capture.Add(in_order ? a : b);
    capture.Add(in_order ? b : a);
    PcapngReader reader(capture.bytes);
    const auto all = ReadAll(reader);
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].bytes, state);
    EXPECT_EQ(all[0].packet.from.address, 0xc0a80001u);
    EXPECT_EQ(all[0].packet.at, Time(std::chrono::microseconds(3)));
  }
}

TEST_F(PcapngTest, LeavesRepeatedTcpBytesOut) {
  const Bytes data = Pattern(30, 9);
  const Bytes head(data.begin(), data.begin() + 20);
  const Bytes overlap(data.begin() + 10, data.end());
  Capture capture(101);
  capture.Add(Ip(6, 0, Tcp(99, 0x02, {})));
  capture.Add(Ip(6, 0, Tcp(100, 0x18, head)));
  capture.Add(Ip(6, 0, Tcp(100, 0x18, head)));
  capture.Add(Ip(6, 0, Tcp(110, 0x18, overlap)));
  PcapngReader reader(capture.bytes);
  const auto all = ReadAll(reader);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(Concatenate({all[0].bytes, all[1].bytes}), data);
}

TEST_F(PcapngTest, CountsWhatIsNeitherUdpNorTcp) {
  Capture capture(101);
  capture.Add(Ip(1, 0, Pattern(8, 0)));
  capture.Add(Pattern(3, 0));
  PcapngReader reader(capture.bytes);
  EXPECT_TRUE(ReadAll(reader).empty());
  EXPECT_EQ(reader.passed_over(), 2u);
}

TEST_F(PcapngTest, RefusesWhatIsNoCapture) {
  EXPECT_THROW(PcapngReader reader(Pattern(100, 0)), InputError);
  EXPECT_THROW(PcapngReader reader(Bytes{}), InputError);
  EXPECT_THROW(PcapngReader reader(folder_.path() / "missing.pcapng"), InputError);
}

TEST_F(PcapngTest, NamesTheOlderFormatAndWhatConvertsIt) {
  // Microseconds and nanoseconds, each in either byte order.
  for (const auto& words : {std::pair{0xd4c3, 0xb2a1}, std::pair{0xa1b2, 0xc3d4},
                            std::pair{0x4d3c, 0xb2a1}, std::pair{0xa1b2, 0x3c4d}}) {
    const Bytes file = Concatenate({BigEndian({static_cast<std::uint16_t>(words.first),
                                               static_cast<std::uint16_t>(words.second)}),
                                    Bytes(20)});
    try {
      PcapngReader reader(file);
      ADD_FAILURE() << "taken: " << std::hex << words.first << words.second;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::AllOf(::testing::HasSubstr("classic pcap"),
                                                 ::testing::HasSubstr("editcap -F pcapng")));
    }
  }
}

TEST_F(PcapngTest, ADirectoryIsRefusedBeforeAnythingIsWritten) {
  EXPECT_THROW(PcapngWriter writer(folder_.path()), EnvironmentError);
  EXPECT_FALSE(std::filesystem::exists(folder_.path().string() + ".partial"));
}

TEST_F(PcapngTest, DamagedFilesEndInAnErrorAndNeverInACrash) {
  const Bytes sample = WriteSample();
  constexpr std::uint64_t kSeed = 20261121;
  const Random random(kSeed, RandomStream::kTest);
  int refused = 0;
  for (std::uint64_t round = 0; round < 3000; ++round) {
    std::uint32_t draw = 0;
    const auto below = [&](std::size_t bound) {
      return static_cast<std::size_t>(random.Uniform(round, draw++) * static_cast<double>(bound));
    };
    Bytes file = sample;
    const std::size_t changes = 1 + below(4);
    for (std::size_t i = 0; i < changes; ++i) {
      // Most of the file is payload: the heads are what matters.
      const std::size_t where = below(below(2) == 0 ? 120 : file.size());
      file[where] = std::byte(below(256));
    }
    if (below(5) == 0) file.resize(below(file.size()));
    try {
      PcapngReader reader(file);
      ReadAll(reader);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100) << "seed " << kSeed;
}

}  // namespace
}  // namespace twin::record::record_pcapng_test

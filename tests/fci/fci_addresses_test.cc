#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <utility>

#include "twin/core/error.h"
#include "twin/fci/sockets.h"

namespace twin::fci::fci_addresses_test {
namespace {

using testing::HasSubstr;

constexpr std::uint32_t kLoopback = 0x7F000001;

template <typename Call>
std::string WhatIsThrown(Call call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

bool IsOpen(int fd) {
  return fcntl(fd, F_GETFD) >= 0;
}

TEST(EndpointTest, IsWrittenAsPeopleWriteIt) {
  EXPECT_EQ(ToString({kLoopback, 1337}), "127.0.0.1:1337");
  EXPECT_EQ(ToString({0, 0}), "0.0.0.0:0");
  EXPECT_EQ(ToString({0xFFFFFFFF, 65535}), "255.255.255.255:65535");
}

TEST(ResolveTest, ReadsAnAddress) {
  EXPECT_EQ(Resolve("127.0.0.1", 1337), (Endpoint{kLoopback, 1337}));
  EXPECT_EQ(Resolve("192.168.1.200", 1), (Endpoint{0xC0A801C8, 1}));
}

TEST(ResolveTest, NamesAHostThatDoesNotExist) {
  // No name server is asked: a name has no empty part.
  const std::string what = WhatIsThrown([] { static_cast<void>(Resolve("no..host", 1337)); });
  EXPECT_THAT(what, HasSubstr("\"no..host\""));
  EXPECT_THAT(what, HasSubstr("IPv4 address"));
}

TEST(ParseNetworkTest, ContainsItsAddressesAndNoOthers) {
  const Network home = ParseNetwork("192.168.1.0/24");
  EXPECT_TRUE(home.Contains(0xC0A80100));
  EXPECT_TRUE(home.Contains(0xC0A801FF));
  EXPECT_FALSE(home.Contains(0xC0A80200));
  EXPECT_FALSE(home.Contains(0xC0A800FF));
  const Network one = ParseNetwork("127.0.0.1/32");
  EXPECT_TRUE(one.Contains(kLoopback));
  EXPECT_FALSE(one.Contains(kLoopback + 1));
  const Network all = ParseNetwork("0.0.0.0/0");
  EXPECT_TRUE(all.Contains(0));
  EXPECT_TRUE(all.Contains(0xFFFFFFFF));
  const Network half = ParseNetwork("128.0.0.0/1");
  EXPECT_TRUE(half.Contains(0x80000000));
  EXPECT_FALSE(half.Contains(0x7FFFFFFF));
}

TEST(ParseNetworkTest, ContainsWhatItsBitsSayForAnyNumberOfThem) {
  for (int bits = 0; bits <= 32; ++bits) {
    const Network network = ParseNetwork("0.0.0.0/" + std::to_string(bits));
    const std::uint64_t size = std::uint64_t{1} << (32 - bits);
    EXPECT_TRUE(network.Contains(static_cast<std::uint32_t>(size - 1))) << bits;
    if (bits > 0) {
      EXPECT_FALSE(network.Contains(static_cast<std::uint32_t>(size))) << bits;
    }
  }
}

TEST(ParseNetworkTest, NamesWhatIsWrong) {
  const std::pair<const char*, const char*> bad[] = {
      {"", "no \"/\""},
      {"10.0.0.1", "no \"/\""},
      {"/24", "no IPv4 address"},
      {"host/24", "no IPv4 address"},
      {"10.0.0/24", "no IPv4 address"},
      {"10.0.0.256/24", "no IPv4 address"},
      {"::1/24", "no IPv4 address"},
      {" 10.0.0.0/24", "no IPv4 address"},
      {"10.0.0.0/", "from 0 to 32"},
      {"10.0.0.0/33", "from 0 to 32"},
      {"10.0.0.0/-1", "from 0 to 32"},
      {"10.0.0.0/24x", "from 0 to 32"},
      {"10.0.0.0/ 24", "from 0 to 32"},
      {"10.0.0.0/99999999999", "from 0 to 32"},
      {"10.0.0.0/8/8", "from 0 to 32"},
      {"192.168.1.5/24", "192.168.1.0/24 does not"},
      {"0.0.0.1/0", "0.0.0.0/0 does not"},
  };
  for (const auto& [text, why] : bad) {
    const std::string what = WhatIsThrown([text = text] { static_cast<void>(ParseNetwork(text)); });
    EXPECT_THAT(what, HasSubstr('"' + std::string(text) + '"'));
    EXPECT_THAT(what, HasSubstr(why));
    EXPECT_THAT(what, HasSubstr("write ADDRESS/BITS"));
  }
}

TEST(FileDescriptorTest, ClosesWhatItHoldsOnce) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  {
    FileDescriptor first(ends[0]);
    FileDescriptor second(std::move(first));
    EXPECT_FALSE(first.valid());  // NOLINT(bugprone-use-after-move): what is left is the claim
    EXPECT_EQ(second.get(), ends[0]);
    EXPECT_TRUE(IsOpen(ends[0]));
    second = FileDescriptor(ends[1]);
    EXPECT_FALSE(IsOpen(ends[0]));
    EXPECT_TRUE(IsOpen(ends[1]));
  }
  EXPECT_FALSE(IsOpen(ends[1]));
}

TEST(FileDescriptorTest, LetsGoOfWhatItReleases) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  FileDescriptor both(ends[0]);
  EXPECT_EQ(both.Release(), ends[0]);
  EXPECT_FALSE(both.valid());
  EXPECT_TRUE(IsOpen(ends[0]));
  const FileDescriptor first(ends[0]);
  const FileDescriptor second(ends[1]);
  EXPECT_FALSE(FileDescriptor().valid());
}

}  // namespace
}  // namespace twin::fci::fci_addresses_test

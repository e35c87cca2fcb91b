#include <gtest/gtest.h>

#include <set>
#include <string>

#include "page/gate.h"
#include "twin/fci/sockets.h"

namespace twin::page {
namespace {

constexpr fci::Endpoint kHere{.address = 0x7f000001, .port = 8080};
constexpr fci::Endpoint kElsewhere{.address = 0xC0A80105, .port = 8080};  // 192.168.1.5

TEST(GateTest, TokensAreOf128BitsAndNeverTheSame) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const std::string token = MakeToken();
    EXPECT_EQ(token.size(), kTokenLetters);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    tokens.insert(token);
  }
  EXPECT_EQ(tokens.size(), 100U);
}

TEST(GateTest, OnlyTheWholeTokenIsTheSame) {
  EXPECT_TRUE(IsSameToken("00ff", "00ff"));
  EXPECT_FALSE(IsSameToken("00fe", "00ff"));
  EXPECT_FALSE(IsSameToken("10ff", "00ff"));
  EXPECT_FALSE(IsSameToken("00f", "00ff"));
  EXPECT_FALSE(IsSameToken("", "00ff"));
}

TEST(GateTest, HostIsTheAddressAndPortOfTheConnection) {
  EXPECT_TRUE(IsOurHost("127.0.0.1:8080", kHere));
  EXPECT_TRUE(IsOurHost("LocalHost:8080", kHere));
  EXPECT_TRUE(IsOurHost("192.168.1.5:8080", kElsewhere));
}

TEST(GateTest, HostOfANameThatResolvesToUsIsNotOurs) {
  EXPECT_FALSE(IsOurHost("evil.example:8080", kHere));
  EXPECT_FALSE(IsOurHost("127.0.0.1.evil.example:8080", kHere));
  EXPECT_FALSE(IsOurHost("127.0.0.1:8081", kHere));
  EXPECT_FALSE(IsOurHost("127.0.0.1", kHere));
  EXPECT_FALSE(IsOurHost("", kHere));
  EXPECT_FALSE(IsOurHost("localhost:8080", kElsewhere));
}

TEST(GateTest, HostMayLeaveOutPort80) {
  constexpr fci::Endpoint kPlain{.address = 0x7f000001, .port = 80};
  EXPECT_TRUE(IsOurHost("localhost", kPlain));
  EXPECT_TRUE(IsOurHost("127.0.0.1:80", kPlain));
}

TEST(GateTest, OriginIsOurOwnPage) {
  EXPECT_TRUE(IsOurOrigin("http://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("null", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("https://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("http://127.0.0.1:8081", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("http://evil.example", "127.0.0.1:8080"));
}

}  // namespace
}  // namespace twin::page

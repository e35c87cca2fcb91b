#include <gtest/gtest.h>

#include <string>

#include "page/origin_check.h"
#include "twin/fci/sockets.h"

namespace twin::page::page_origin_check_test {
namespace {

constexpr fci::Endpoint kHere{.address = 0x7f000001, .port = 8080};
constexpr fci::Endpoint kElsewhere{.address = 0xC0A80105, .port = 8080};  // 192.168.1.5

TEST(OriginCheckTest, HostIsTheAddressAndPortOfTheConnection) {
  EXPECT_TRUE(IsOurHost("127.0.0.1:8080", kHere));
  EXPECT_TRUE(IsOurHost("LocalHost:8080", kHere));
  EXPECT_TRUE(IsOurHost("192.168.1.5:8080", kElsewhere));
}

TEST(OriginCheckTest, HostOfANameThatResolvesToUsIsNotOurs) {
  EXPECT_FALSE(IsOurHost("evil.example:8080", kHere));
  EXPECT_FALSE(IsOurHost("127.0.0.1.evil.example:8080", kHere));
  EXPECT_FALSE(IsOurHost("127.0.0.1:8081", kHere));
  EXPECT_FALSE(IsOurHost("127.0.0.1", kHere));
  EXPECT_FALSE(IsOurHost("", kHere));
  EXPECT_FALSE(IsOurHost("localhost:8080", kElsewhere));
}

TEST(OriginCheckTest, HostMayLeaveOutPort80) {
  constexpr fci::Endpoint kPlain{.address = 0x7f000001, .port = 80};
  EXPECT_TRUE(IsOurHost("localhost", kPlain));
  EXPECT_TRUE(IsOurHost("127.0.0.1:80", kPlain));
}

TEST(OriginCheckTest, OriginIsOurOwnPage) {
  EXPECT_TRUE(IsOurOrigin("http://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("null", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("https://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("http://127.0.0.1:8081", "127.0.0.1:8080"));
  EXPECT_FALSE(IsOurOrigin("http://evil.example", "127.0.0.1:8080"));
}

}  // namespace
}  // namespace twin::page::page_origin_check_test

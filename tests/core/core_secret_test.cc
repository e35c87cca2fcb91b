#include "twin/core/secret.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace twin::core_secret_test {
namespace {

TEST(SecretTest, IsOfHexadecimalLettersAndNeverTheSame) {
  std::set<std::string> secrets;
  for (int i = 0; i < 100; ++i) {
    const std::string secret = MakeSecret(16);
    EXPECT_EQ(secret.size(), 16U);
    EXPECT_EQ(secret.find_first_not_of("0123456789abcdef"), std::string::npos);
    secrets.insert(secret);
  }
  EXPECT_EQ(secrets.size(), 100U);
}

TEST(SecretTest, IsTheSameOnlyInFull) {
  EXPECT_TRUE(IsSameSecret("00ff", "00ff"));
  EXPECT_FALSE(IsSameSecret("00fe", "00ff"));
  EXPECT_FALSE(IsSameSecret("10ff", "00ff"));
  EXPECT_FALSE(IsSameSecret("00f", "00ff"));
  EXPECT_FALSE(IsSameSecret("", "00ff"));
}

}  // namespace
}  // namespace twin::core_secret_test

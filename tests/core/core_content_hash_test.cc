#include <gtest/gtest.h>

#include "twin/core/content_hash.h"

namespace twin::core_content_hash_test {
namespace {

std::string HashOf(std::initializer_list<std::string_view> strings) {
  ContentHash hash;
  for (const auto text : strings) hash.Add(text);
  return hash.Hex();
}

// Published digests of MurmurHash3 x64 128, seed 0.
TEST(ContentHashTest, EqualsMurmur3OnKnownStrings) {
  EXPECT_EQ(HashOf({""}), "00000000000000000000000000000000");
  EXPECT_EQ(HashOf({"The quick brown fox jumps over the lazy dog"}),
            "e34bbc7bbc071b6c7a433ca9c49a9347");
}

TEST(ContentHashTest, TellsWhereOneStringEnds) {
  EXPECT_NE(HashOf({"ab", "c"}), HashOf({"a", "bc"}));
  EXPECT_NE(HashOf({"abc"}), HashOf({"abc", ""}));
}

TEST(ContentHashTest, SeesASingleBit) {
  std::string text(1000, 'x');
  const std::string before = HashOf({text});
  text[997] ^= 1;
  EXPECT_NE(HashOf({text}), before);
}

}  // namespace
}  // namespace twin::core_content_hash_test

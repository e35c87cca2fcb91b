#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "campaign/shrink.h"

namespace twin::campaign::campaign_shrink_test {
namespace {

constexpr std::string_view kWorld = R"(name: "world_7"
seed: 7
link:
  command_loss: 3 %
  d_INT: 200 us
panel:
  - {press: stop}
  - {release: stop}
)";

bool Has(const std::string& text, std::string_view what) {
  return text.find(what) != std::string::npos;
}

TEST(Shrink, LeavesTheNameAndWhatFails) {
  const auto fails = [](const std::string& text) { return Has(text, "d_INT"); };
  EXPECT_EQ(Shrink(std::string(kWorld), fails), "name: \"world_7\"\nlink:\n  d_INT: 200 us\n");
}

TEST(Shrink, TakesElementsOfListsAway) {
  const auto fails = [](const std::string& text) { return Has(text, "release"); };
  EXPECT_EQ(Shrink(std::string(kWorld), fails), "name: \"world_7\"\npanel:\n  - {release: stop}\n");
}

/// The seed is needed while something is pressed, which goes later.
TEST(Shrink, TriesAgainWhatStayed) {
  const auto fails = [](const std::string& text) {
    return Has(text, "release") && (Has(text, "seed") || !Has(text, "press"));
  };
  EXPECT_EQ(Shrink(std::string(kWorld), fails), "name: \"world_7\"\npanel:\n  - {release: stop}\n");
}

}  // namespace
}  // namespace twin::campaign::campaign_shrink_test

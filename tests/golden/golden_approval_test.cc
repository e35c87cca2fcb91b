#include "twin/golden/approval.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "golden/made_up_golden.h"
#include "twin/core/error.h"

namespace twin::golden::golden_approval_test {
namespace {

class ApprovalTest : public testing::Test {
 protected:
  Approved Approve(std::uint64_t states = 7) {
    return golden::Approve(old_, {&pictures_, states, {}}, "because", "9.9");
  }

  Pictures pictures_ = GreyPictures();
  std::optional<Golden> old_ = GoldenOf(GreyPictures());
};

TEST_F(ApprovalTest, TheFirstKeepsAllAndTheReason) {
  old_.reset();
  const Approved first = Approve();
  EXPECT_TRUE(first.changed);
  EXPECT_EQ(first.golden.states, std::vector<std::uint64_t>{7});
  ASSERT_EQ(first.golden.renderings.size(), 1U);
  EXPECT_EQ(first.golden.renderings[0][1], pictures_.views[1].hashes);
  ASSERT_EQ(first.golden.approvals.size(), 1U);
  EXPECT_EQ(first.golden.approvals[0].reason, "because");
  EXPECT_EQ(first.golden.approvals[0].version, "9.9");
  EXPECT_EQ(Compare(first.golden, {&pictures_, 7, {}}).verdict, Verdict::kSame);
}

TEST_F(ApprovalTest, OfWhatWasApprovedChangesNothing) {
  const Approved again = Approve();
  EXPECT_FALSE(again.changed);
  EXPECT_EQ(again.golden.approvals.size(), 1U);
}

TEST_F(ApprovalTest, OfOtherBitsThatLookTheSameAddsHashesAndKeepsThePictures) {
  pictures_.views[0].hashes[1] = 5;
  pictures_.views[0].keys[0].colour.rgb[0] ^= 1;
  const Approved added = Approve(8);
  EXPECT_TRUE(added.changed);
  EXPECT_EQ(added.golden.states, (std::vector<std::uint64_t>{7, 8}));
  EXPECT_EQ(added.golden.renderings.size(), 2U);
  EXPECT_EQ(added.golden.pictures.views[0].keys[0].colour, old_->pictures.views[0].keys[0].colour);
  EXPECT_EQ(added.golden.approvals.back().changed, "a hash of the states, hashes of the frames");
  EXPECT_EQ(Compare(added.golden, {&pictures_, 8, {}}).verdict, Verdict::kSame);
}

TEST_F(ApprovalTest, OfOtherPicturesReplacesThemAndForgetsTheOldHashes) {
  for (std::uint8_t& byte : pictures_.views[0].keys[0].colour.rgb) byte += 9;
  const Approved replaced = Approve(8);
  EXPECT_EQ(replaced.golden.states, std::vector<std::uint64_t>{8});
  EXPECT_EQ(replaced.golden.pictures.views[0].keys[0].colour, pictures_.views[0].keys[0].colour);
  ASSERT_EQ(replaced.golden.approvals.size(), 2U);
  EXPECT_EQ(replaced.golden.approvals[0].reason, "made up");
  EXPECT_THAT(replaced.golden.approvals[1].changed, testing::HasSubstr("the physics changed"));
}

TEST_F(ApprovalTest, OfOtherViewsOrKeyPicturesReplacesThem) {
  pictures_.views[0].keys.pop_back();
  EXPECT_EQ(Approve().golden.pictures.views[0].keys.size(), 1U);
  pictures_.views.pop_back();
  EXPECT_EQ(Approve().golden.pictures.views.size(), 1U);
}

TEST_F(ApprovalTest, NeedsAReason) {
  for (const char* blank : {"", "  \t"}) {
    EXPECT_THROW(static_cast<void>(golden::Approve(old_, {&pictures_, 7, {}}, blank, "1")),
                 InputError);
  }
}

}  // namespace
}  // namespace twin::golden::golden_approval_test

#include "twin/golden/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "golden/made_up_golden.h"
#include "support/temporary_folder.h"

namespace twin::golden::golden_page_test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A case whose picture of frame 4 differs in one place of the view hand.
CaseResult Differing() {
  CaseResult result{"a<b>", "scenario & lab", "panda-twin video approve \"a\"", {}, {}, {}, {}};
  result.golden = GoldenOf(GreyPictures());
  result.pictures = GreyPictures();
  render::Image& picture = result.pictures.views[1].keys[1].colour;
  for (std::size_t i = 0; i < 300; ++i) picture.rgb[i] -= 10;
  result.comparison = Compare(result.golden, {&result.pictures, 7, {}});
  for (int i = 0; i < 5; ++i) {
    result.joints.t.push_back(0.25 * i);
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      result.joints.q[joint].push_back(0.1 * i);
      result.joints.q_d[joint].push_back(0.11 * i);
    }
  }
  return result;
}

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(PageTest, NeedsNoOtherFile) {
  const std::string page = PageOf(std::vector{Differing()});
  EXPECT_THAT(page, Not(testing::ContainsRegex("src=\"[^d]|href=\"[^#]|@import|fetch\\(")));
}

TEST(PageTest, TellsVerdictPlaceGatesAndHowToApprove) {
  const std::string page = PageOf(std::vector{Differing()});
  EXPECT_THAT(page, HasSubstr("first at frame 4 (0.80 s), view hand"));
  EXPECT_THAT(page, HasSubstr("panda-twin video approve &quot;a&quot;"));
  for (std::size_t i = 0; i < kGates; ++i) {
    EXPECT_THAT(page, HasSubstr("<td>" + std::string(Name(static_cast<Gate>(i))) + "</td>"));
  }
  EXPECT_THAT(page, HasSubstr("\"first\":4,\"firstView\":1"));
}

TEST(PageTest, IsKnownAgain) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "page.html") << PageOf(std::vector{Differing()});
  std::ofstream(folder / "other.html") << "<title>panda-twin: demo</title>";
  EXPECT_TRUE(IsPage(folder / "page.html"));
  EXPECT_FALSE(IsPage(folder / "other.html"));
  EXPECT_FALSE(IsPage(folder / "none.html"));
}

TEST(PageTest, EscapesWhatItIsGiven) {
  const std::string page = PageOf(std::vector{Differing()});
  EXPECT_THAT(page, HasSubstr("a&lt;b&gt;"));
  EXPECT_THAT(page, HasSubstr("scenario &amp; lab"));
  EXPECT_THAT(page, Not(HasSubstr("a<b>")));
}

TEST(PageTest, HoldsPicturesOnceThatAreTheSame) {
  // Expected: two strips, four key pictures. Actual: one key picture that differs.
  EXPECT_EQ(Count(PageOf(std::vector{Differing()}), "data:image/png"), 7U);
}

TEST(PageTest, TheSameResultsGiveTheSameBytes) {
  EXPECT_EQ(PageOf(std::vector{Differing()}), PageOf(std::vector{Differing()}));
}

TEST(JUnitTest, CountsAndTellsFailures) {
  CaseResult good = Differing();
  good.pictures = GreyPictures();
  good.comparison = Compare(good.golden, {&good.pictures, 7, {}});
  const std::string xml = JUnitOf(std::vector{Differing(), good});
  EXPECT_THAT(xml, HasSubstr("tests=\"2\" failures=\"1\""));
  EXPECT_THAT(xml, HasSubstr("name=\"a&lt;b&gt;\"><failure message=\"the rendering changed"));
  EXPECT_EQ(Count(xml, "<failure"), 1U);
}

}  // namespace
}  // namespace twin::golden::golden_page_test

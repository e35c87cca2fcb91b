#include "twin/report/page.h"

#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "report/templates.h"

namespace twin::report::report_page_test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

/// A row of experiment/comparisons.html.
std::string RowWith(const json& ours) {
  return RenderPage(
      "experiment/comparisons",
      {{"compared", true}, {"comparisons", {{{"quantity", "a < b & \"c\""}, {"ours", ours}}}}});
}

TEST(RenderPageTest, EscapesTexts) {
  EXPECT_THAT(RowWith("<i>\x01"), HasSubstr("<td>&lt;i&gt; </td>"));
  EXPECT_THAT(RowWith(1), HasSubstr("<td>a &lt; b &amp; &quot;c&quot;</td>"));
}

TEST(RenderPageTest, ShowsNumbersWithFourDigits) {
  EXPECT_THAT(RowWith(1234.56), HasSubstr("<td>1235</td>"));
  EXPECT_THAT(RowWith(1234567), HasSubstr("<td>1234567</td>"));
  EXPECT_THAT(RowWith(1.0), HasSubstr("<td>1</td>"));
  EXPECT_THAT(RowWith(std::numeric_limits<double>::infinity()), HasSubstr("<td>none</td>"));
  EXPECT_THAT(RowWith(json()), HasSubstr("<td></td>"));
}

TEST(RenderPageTest, LeavesOutSectionsWithoutAnything) {
  for (const json& nothing : {json(), json(false), json(""), json::array()}) {
    const std::string page =
        RenderPage("experiment/comparisons", {{"compared", nothing}, {"comparisons", {{}}}});
    EXPECT_THAT(page, Not(HasSubstr("<table>"))) << nothing;
  }
}

TEST(RenderPageTest, HeadAndFootMakeAWholeFile) {
  const std::string page = RenderPage("experiment/report", {{"title", "a & b"}});
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
  EXPECT_THAT(page, HasSubstr("</body>\n</html>\n"));
  EXPECT_THAT(page, HasSubstr("<title>a &amp; b</title>"));
  EXPECT_THAT(page, HasSubstr("border-collapse:collapse"));
  EXPECT_THAT(page, HasSubstr("name=\"viewport\" content=\"width=device-width"));
  EXPECT_THAT(page, Not(HasSubstr("{{")));
}

// A template that is not closed, or takes in one that is not there.
TEST(RenderPageTest, EveryTemplateIsOne) {
  for (const TemplateFile& file : TemplateFiles()) {
    if (!file.name.ends_with(".html")) continue;
    const std::string name(file.name.substr(0, file.name.size() - 5));
    EXPECT_THAT(RenderPage(name, json::object()), Not(HasSubstr("{{"))) << name;
    for (std::size_t at = file.text.find("{{> "); at != std::string_view::npos;
         at = file.text.find("{{> ", at + 1)) {
      const std::string_view part = file.text.substr(at + 4, file.text.find("}}", at) - at - 4);
      const bool is_there = std::ranges::any_of(TemplateFiles(), [&](const TemplateFile& other) {
        return other.name == part || other.name == std::string(part) + ".html";
      });
      EXPECT_TRUE(is_there) << name << " takes in " << part;
    }
  }
}

TEST(Base64Test, PadsToFourLetters) {
  EXPECT_EQ(Base64("M"), "TQ==");
  EXPECT_EQ(Base64("Ma"), "TWE=");
  EXPECT_EQ(Base64("Man"), "TWFu");
}

}  // namespace
}  // namespace twin::report::report_page_test

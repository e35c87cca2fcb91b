#include "twin/experiment/page.h"

#include <limits>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/experiment/experiment.h"
#include "twin/report/chart.h"
#include "twin/report/html.h"

namespace twin::experiment {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Comparison Compared(Verdict verdict) {
  return {.quantity = "a < b",
          .unit = "ms",
          .paper = 2,
          .ours = 3,
          .low = 1,
          .high = 4,
          .demand = "within 20 %",
          .verdict = verdict};
}

Figure Drawn(const std::string& id) {
  const report::ChartCurve curve{.name = "c", .x = {1, 2}, .y = {3, 4}};
  return {.id = id,
          .title = "a figure",
          .what = "what to see",
          .svg = report::DrawChart({.panels = {{.curves = {curve}}}}),
          .columns = "x [s],y [1]",
          .rows = {{1, 3}, {2, std::numeric_limits<double>::quiet_NaN()}}};
}

Findings Found(std::vector<Comparison> comparisons) {
  return {.id = "one",
          .title = "The first",
          .source = "Section 1",
          .text = "how it & was done",
          .comparisons = std::move(comparisons)};
}

TEST(ComparisonTest, RatioIsToThePapersFigure) {
  EXPECT_EQ(Compared(Verdict::kPredicted).ratio(), 1.5);
  EXPECT_EQ(Comparison{.ours = 3}.ratio(), std::nullopt);
  EXPECT_EQ((Comparison{.paper = 0, .ours = 3}).ratio(), std::nullopt);
}

TEST(FindingsTest, SucceedUnlessSomethingFailedOrIsNotReproducedForNoKnownReason) {
  EXPECT_TRUE(Found({Compared(Verdict::kPredicted), Compared(Verdict::kCalibrated),
                     Compared(Verdict::kReported)})
                  .succeeded());
  Comparison missed = Compared(Verdict::kNotReproduced);
  EXPECT_FALSE(Found({Compared(Verdict::kPredicted), missed}).succeeded());
  missed.reason = "because";
  EXPECT_TRUE(Found({missed}).succeeded());
  Findings failed = Found({});
  failed.failure = "no";
  EXPECT_FALSE(failed.succeeded());
}

TEST(OutcomeTest, CountsPredictionsAlone) {
  const auto calibrated = Compared(Verdict::kCalibrated);
  const auto predicted = Compared(Verdict::kPredicted);
  EXPECT_EQ(Outcome(Found({})), "nothing demanded");
  EXPECT_EQ(Outcome(Found({calibrated, Compared(Verdict::kReported)})),
            "nothing demanded; 1 calibrated");
  EXPECT_EQ(Outcome(Found({predicted, calibrated, Compared(Verdict::kReported)})),
            "1 of 1 demands met; 1 calibrated");
  EXPECT_EQ(Outcome(Found({predicted, Compared(Verdict::kNotReproduced)})),
            "1 of 2 demands met; 1 not reproduced");
}

TEST(MissedLinesTest, NameEachDemandThatIsMissedForNoKnownReason) {
  Comparison known = Compared(Verdict::kNotReproduced);
  known.reason = "because";
  EXPECT_EQ(
      MissedLines(Found({Compared(Verdict::kPredicted), Compared(Verdict::kNotReproduced), known})),
      "a < b: 3 ms; the paper's is 2 ms; demanded: within 20 %\n");
  EXPECT_THAT(MissedLines(Found({Compared(Verdict::kPredicted)})), IsEmpty());
}

TEST(PageTest, ShowsEveryFigureOfAComparison) {
  std::vector<Findings> findings{Found({Compared(Verdict::kNotReproduced)})};
  findings[0].comparisons[0].reason = "it > all";
  const std::string html = Page(findings, {});
  EXPECT_THAT(html,
              HasSubstr("<td>a &lt; b</td><td class=\"word\">ms</td><td>2</td><td>3</td>"
                        "<td>1.5</td><td>1 … 4</td><td class=\"word\">within 20 %; it &gt; all</td>"
                        "<td class=\"missed\">not reproduced</td>"));
  EXPECT_THAT(html, HasSubstr("how it &amp; was done"));
}

TEST(PageTest, MarksAnExperimentThatFailed) {
  std::vector<Findings> findings{Found({}), Found({})};
  findings[0].failure = "the <disk> is full";
  const std::string html = Page(findings, {});
  EXPECT_THAT(html, HasSubstr("<p class=\"failed\">failed: the &lt;disk&gt; is full</p>"));
  EXPECT_THAT(html, HasSubstr("<td class=\"failed\">failed</td>"));
  EXPECT_THAT(html, HasSubstr("<td class=\"reported\">nothing demanded</td>"));
}

TEST(PageTest, TellsHowItWasMade) {
  const std::string html = Page(
      {}, {.seed = 77, .seeds = 5, .calibration = "abc", .parameters = "x: <1>", .version = "9"});
  for (const char* fact : {"<td class=\"word\">77</td>", "<td class=\"word\">5</td>",
                           "<td class=\"word\">abc</td>", "x: &lt;1&gt;\n"}) {
    EXPECT_THAT(html, HasSubstr(fact));
  }
}

TEST(PageTest, NeedsNoNetworkAndNoOtherFile) {
  std::vector<Findings> findings{Found({Compared(Verdict::kPredicted)})};
  findings[0].figures = {Drawn("f")};
  std::string html = Page(findings, {});
  for (const char* reference : {"src=", "<link", "<script", "@import", "url(http"}) {
    EXPECT_THAT(html, Not(HasSubstr(reference)));
  }
}

TEST(PageTest, NoNameIsThereTwice) {
  std::vector<Findings> findings{Found({})};
  findings[0].figures = {Drawn("f"), Drawn("g")};
  const std::string html = Page(findings, {});
  std::set<std::string> names;
  for (const char quote : {'"', '\''}) {
    const std::string before = std::string(" id=") + quote;
    for (std::size_t at = html.find(before); at != std::string::npos; at = html.find(before, at)) {
      at += before.size();
      const std::string name = html.substr(at, html.find(quote, at) - at);
      EXPECT_TRUE(names.insert(name).second) << name;
    }
  }
  EXPECT_TRUE(names.contains("one_g-gpDot"));
  EXPECT_THAT(html, Not(HasSubstr("gnuplot_plot_1a</title>")));
  EXPECT_THAT(html, HasSubstr("href='#one_g-gpPt5'"));
}

TEST(CsvTest, HasALineForEveryRow) {
  EXPECT_EQ(Csv(Drawn("f")), "x [s],y [1]\n1,3\n2,\n");
  EXPECT_EQ(CsvName(Found({}), Drawn("f")), "one_f.csv");
}

TEST(ExperimentsTest, HaveNamesThatFilesCanHave) {
  std::set<std::string_view> ids;
  for (const Experiment& experiment : Experiments()) {
    EXPECT_TRUE(ids.insert(experiment.id).second) << experiment.id;
    EXPECT_EQ(experiment.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"),
              std::string_view::npos);
    EXPECT_NE(experiment.run, nullptr);
    EXPECT_FALSE(experiment.title.empty());
  }
}

}  // namespace
}  // namespace twin::experiment

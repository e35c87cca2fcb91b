#include "twin/experiment/page.h"

#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/experiment/experiment.h"

namespace twin::experiment::experiment_page_test {
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
  return {.id = id,
          .plot = "convergence",
          .columns =
              "lambda,formula [s],joint [s],translation [s],rotation [s],jerk per offset [1/s^3]",
          .rows = {{1e-3, 3, 3, 3, 3, 1}, {1e-2, 1, 1, 1, 1, 10}}};
}

Findings Found(std::vector<Comparison> comparisons) {
  return {.id = "lambda",
          .title = "The first",
          .source = "Section 1",
          .page = "client",
          .values = {{"command", "how it & was done"}},
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
            "1 of 1 demands met, 1 of them on figures of the paper; 1 calibrated");
  Comparison own = predicted;
  own.paper.reset();
  EXPECT_EQ(Outcome(Found({predicted, own, Compared(Verdict::kNotReproduced)})),
            "2 of 3 demands met, 1 of them on figures of the paper; 1 not reproduced");
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
                           "<td class=\"word\">abc</td>", "<pre>x: &lt;1&gt;</pre>"}) {
    EXPECT_THAT(html, HasSubstr(fact));
  }
}

TEST(PageTest, NeedsNoNetworkAndNoOtherFile) {
  std::vector<Findings> findings{Found({Compared(Verdict::kPredicted)})};
  findings[0].page = "lambda";
  findings[0].figures = {Drawn("stalls")};
  std::string html = Page(findings, {});
  for (const char* reference : {"src=", "<link", "<script", "@import", "url(http"}) {
    EXPECT_THAT(html, Not(HasSubstr(reference)));
  }
}

TEST(PageTest, NoNameIsThereTwice) {
  std::vector<Findings> findings{Found({})};
  findings[0].page = "lambda";
  findings[0].figures = {Drawn("convergence"), Drawn("stalls")};
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
  EXPECT_TRUE(names.contains("lambda_stalls-gpDot"));
  EXPECT_THAT(html, Not(HasSubstr("gnuplot_plot_1a</title>")));
  EXPECT_THAT(html, HasSubstr("href='#lambda_stalls-gpPt6'"));
}

TEST(CsvNameTest, IsThatOfExperimentAndFigure) {
  EXPECT_EQ(CsvName(Found({}), Drawn("f")), "lambda_f.csv");
  std::vector<Findings> findings{Found({})};
  findings[0].page = "lambda";
  findings[0].figures = {Drawn("stalls")};
  EXPECT_EQ(CsvNamesOf(Page(findings, {})), std::vector<std::string>{"lambda_stalls.csv"});
}

TEST(ExperimentsTest, HaveNamesThatFilesCanHave) {
  std::set<std::string_view> ids;
  for (const Experiment& experiment : Experiments()) {
    EXPECT_TRUE(ids.insert(experiment.id).second) << experiment.id;
    EXPECT_EQ(experiment.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"),
              std::string_view::npos);
    EXPECT_NE(experiment.run, nullptr);
    EXPECT_FALSE(experiment.title.empty());
    EXPECT_FALSE(experiment.source.empty());
  }
}

}  // namespace
}  // namespace twin::experiment::experiment_page_test

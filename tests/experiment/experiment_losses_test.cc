#include "experiment/studies.h"

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"

namespace twin::experiment::experiment_losses_test {
namespace {

const Comparison& Named(const Findings& findings, std::string_view begin, std::string_view part) {
  const auto found = std::ranges::find_if(findings.comparisons, [&](const Comparison& comparison) {
    return comparison.quantity.starts_with(begin) &&
           comparison.quantity.find(part) != std::string::npos;
  });
  EXPECT_NE(found, findings.comparisons.end()) << begin << ", " << part;
  return *found;
}

TEST(LossesTest, BurstsEndWhatIsNotMadeForThemAndNothingOfOurs) {
  const test::ExperimentBench bench;
  const Findings findings = RunLosses(bench.short_config(1));
  EXPECT_TRUE(findings.succeeded());
  for (const char* pace : {"canonical", "brisk", "hard"}) {
    EXPECT_EQ(Named(findings, pace, "viability filter").ours, 0) << pace;
  }
  EXPECT_GT(Named(findings, "brisk", "stream of positions").ours, 0);
  EXPECT_LT(Named(findings, "hard, bursts of 19, rejoining", "RMS error").ours, 1) << "mrad";
  EXPECT_EQ(Named(findings, "all tempos", "every length").ours, 0);
  EXPECT_EQ(Named(findings, "hard, rejoining", "up to this length").ours, 19);
  EXPECT_LT(Named(findings, "hard, stream of positions", "up to this length").ours, 19);
  EXPECT_EQ(findings.figures.size(), 3U);
  EXPECT_EQ(test::FiguresOnPage(findings, "losses"), 3U);
}

TEST(LossesTest, APaceThatCompletesNoMotionIsDrawn) {
  Figure figure{.id = "bursts",
                .plot = "outcomes",
                .columns = "commands lost in a row,tempo [-],way [-],aborted [%],RMS error [mrad]",
                .names = {"a", "b", "c", "d", "e", "commands lost in a row", "Bursts"}};
  for (const int pace : {0, 1, 2}) {
    figure.values["completed_" + std::to_string(pace)] = pace == 0 ? 1 : 0;
    for (const double lost : {1, 3}) {
      const double error = pace == 0 ? 1 : std::numeric_limits<double>::quiet_NaN();
      figure.rows.push_back({lost, 1.0 * pace, 0, 100, error});
    }
  }
  EXPECT_EQ(test::FiguresOnPage({.figures = {figure}}, "losses"), 1U);
}

}  // namespace
}  // namespace twin::experiment::experiment_losses_test

#include "experiment/studies.h"

#include <algorithm>
#include <string_view>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"

namespace twin::experiment {
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

}  // namespace
}  // namespace twin::experiment

#include "twin/record/cycle_record.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

namespace twin::record::record_filter_counts_test {
namespace {

TickRecord Tick(std::optional<double> margin, std::uint8_t kept_back, int at_ms) {
  TickRecord tick;
  tick.action = TickAction::kWritten;
  tick.read = Time(std::chrono::milliseconds(at_ms));
  tick.margin = margin;
  tick.kept_back = kept_back;
  return tick;
}

TEST(FilterCountsTest, CountsCommandsAndTheJointsThatWereKeptBack) {
  FilterCounts counts;
  counts.Add(Tick(0.5, 0, 1));
  counts.Add(Tick(0.2, 0b1000001, 2));
  counts.Add(Tick(0.3, 0b0000001, 3));
  counts.Add(Tick(0.4, 0, 4));
  EXPECT_EQ(counts.commands, 4U);
  EXPECT_EQ(counts.kept_back, 2U);
  EXPECT_EQ(counts.kept_back_percent(), 50);
  EXPECT_EQ(counts.of_joint, (std::array<std::uint64_t, kJoints>{2, 0, 0, 0, 0, 0, 1}));
}

TEST(FilterCountsTest, KeepsWhereTheMarginWasLeast) {
  FilterCounts counts;
  for (const auto& [margin, at_ms] : {std::pair{0.5, 1}, {0.2, 2}, {0.3, 3}, {0.2, 4}}) {
    counts.Add(Tick(margin, 0, at_ms));
  }
  ASSERT_TRUE(counts.nearest.has_value());
  EXPECT_EQ(counts.nearest->margin, 0.2);
  EXPECT_EQ(counts.nearest->at, Time(std::chrono::milliseconds(2))) << "the first of equals";
}

TEST(FilterCountsTest, LeavesOutTicksWithoutAFilterOrACommand) {
  FilterCounts counts;
  counts.Add(Tick({}, 0, 1));
  TickRecord skipped = Tick(0.1, 1, 2);
  skipped.action = TickAction::kSkipped;
  counts.Add(skipped);
  EXPECT_EQ(counts.commands, 0U);
  EXPECT_EQ(counts.kept_back_percent(), 0);
  EXPECT_FALSE(counts.nearest.has_value());
}

}  // namespace
}  // namespace twin::record::record_filter_counts_test

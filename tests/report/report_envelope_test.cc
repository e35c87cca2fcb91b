#include "report/envelope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "report/run_data.h"

namespace twin::report::report_envelope_test {
namespace {

TEST(EnvelopeTest, KeepsEverySampleWhileThereIsRoom) {
  Envelope envelope(2, 10);
  for (int k = 0; k < 10; ++k) envelope.Add(k, std::array{1.0 * k, -2.0 * k});
  const auto curve = envelope.Curve(1);
  ASSERT_EQ(curve.size(), 10U);
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(curve[static_cast<std::size_t>(k)].time, k);
    EXPECT_EQ(curve[static_cast<std::size_t>(k)].value, -2.0 * k);
  }
}

TEST(EnvelopeTest, KeepsASinglePeakOfALongCurveAtItsTime) {
  Envelope envelope(1, 16);
  for (int k = 0; k < 100'000; ++k) {
    envelope.Add(k, std::array{k == 77'777 ? 5.0 : k == 33'333 ? -4.0 : std::sin(k)});
  }
  const auto curve = envelope.Curve(0);
  EXPECT_LE(curve.size(), 2U * 16);
  EXPECT_GE(curve.size(), 16U);
  const auto [lowest, highest] = std::ranges::minmax_element(curve, {}, &Sample::value);
  EXPECT_EQ(highest->value, 5.0);
  EXPECT_EQ(highest->time, 77'777);
  EXPECT_EQ(lowest->value, -4.0);
  EXPECT_EQ(lowest->time, 33'333);
  EXPECT_TRUE(std::ranges::is_sorted(curve, {}, &Sample::time));
}

TEST(EnvelopeTest, LeavesOutWhatIsNotFinite) {
  Envelope envelope(1, 4);
  envelope.Add(0, std::array{std::numeric_limits<double>::quiet_NaN()});
  EXPECT_TRUE(envelope.Curve(0).empty());
  envelope.Add(1, std::array{3.0});
  for (int k = 2; k < 20; ++k) envelope.Add(k, std::array{std::numeric_limits<double>::infinity()});
  ASSERT_EQ(envelope.Curve(0).size(), 1U);
  EXPECT_EQ(envelope.Curve(0)[0].value, 3.0);
}

TEST(FateHistoryTest, LosesNoCycleWhenSpansAreMerged) {
  FateHistory history;
  record::CycleRecord cycle;
  for (int k = 0; k < 50'001; ++k) {
    cycle.at = Time(k * kCycle);
    cycle.fate = static_cast<record::CommandFate>(k % 3);
    cycle.dropped = k % 5 == 0 ? 1 : 0;
    history.Add(cycle);
  }
  FateCounts total;
  for (const FateCounts& span : history.spans()) {
    total.Add(span);
    if (&span != &history.spans().back()) {
      EXPECT_EQ(span.cycles(), history.cycles_per_span());
    }
  }
  EXPECT_EQ(total.none, 16'667U);
  EXPECT_EQ(total.served, 16'667U);
  EXPECT_EQ(total.held, 16'667U);
  EXPECT_EQ(total.dropped, 10'001U);
  EXPECT_LE(history.spans().size(), 300U);
}

}  // namespace
}  // namespace twin::report::report_envelope_test

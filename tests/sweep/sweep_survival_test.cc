#include "sweep/survival.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"

namespace twin::sweep::sweep_survival_test {
namespace {

Sweep SweepOf(const std::string& axis) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "base.yaml") << "name: base\n";
  std::ofstream(folder / "s.yaml") << "name: s\nscenario: base.yaml\naxes:\n  - " << axis << "\n";
  return {folder / "s.yaml", folder.path()};
}

Result EndedAt(double seconds, bool failed) {
  Result result;
  result.outcome = failed ? "aborted" : "success";
  result.duration_s = seconds;
  return result;
}

TEST(SurvivalCountTest, EndsAtTheShareOfSuccesses) {
  const Sweep sweep = SweepOf("{key: a, values: {one: 1, two: 2}}");
  SurvivalCount count(sweep);
  const Case one{.point = 0, .seed = 1, .values = {"1"}};
  for (const auto& [seconds, failed] :
       {std::pair(2.0, true), std::pair(1.0, true), std::pair(1.5, false), std::pair(3.0, false)}) {
    count.Add(one, EndedAt(seconds, failed));
  }
  count.Add({.point = 1, .seed = 1, .values = {"2"}}, EndedAt(5, false));
  const std::vector<SurvivalCurve> curves = count.Curves();
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_EQ(curves[0].label, "one");
  EXPECT_EQ(curves[0].runs, 4U);
  EXPECT_EQ(curves[0].failures, 2U);
  EXPECT_EQ(curves[0].end_s, 3);
  ASSERT_EQ(curves[0].steps.size(), 2U);
  EXPECT_EQ(curves[0].steps[0].time_s, 1);
  EXPECT_EQ(curves[0].steps[0].share, 0.75);
  EXPECT_EQ(curves[0].steps[1].time_s, 2);
  EXPECT_EQ(curves[0].steps[1].share, 0.5);
  EXPECT_THAT(curves[1].steps, testing::IsEmpty());
  EXPECT_EQ(curves[1].end_s, 5);
}

TEST(SurvivalCountTest, MakesOneCurveWhereTheFirstAxisHasManyValues) {
  const Sweep sweep = SweepOf("{key: a, from: 1, to: 9, steps: 9}");
  SurvivalCount count(sweep);
  for (std::uint64_t run = 0; run < sweep.runs(); ++run) {
    count.Add(sweep.CaseAt(run), EndedAt(1, false));
  }
  ASSERT_EQ(count.Curves().size(), 1U);
  EXPECT_EQ(count.Curves()[0].label, "all runs");
  EXPECT_EQ(count.Curves()[0].runs, 9U);
}

}  // namespace
}  // namespace twin::sweep::sweep_survival_test

#include "twin/sweep/points.h"

#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"
#include "twin/sweep/shard.h"

namespace twin::sweep::sweep_points_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A file in a folder of the test's own, with a scenario beside it.
Sweep SweepOf(const std::string& text) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "base.yaml") << "name: base\n";
  std::ofstream(folder / "s.yaml") << "name: s\nscenario: base.yaml\n" << text;
  return {folder / "s.yaml", folder.path()};
}

TEST(SweepTest, TakesTheLastAxisFastestAndSeedsWithinAPoint) {
  const Sweep sweep = SweepOf(
      "axes:\n"
      "  - {key: a, values: [1 %, {b: [2, x y]}]}\n"
      "  - {key: c.d, from: 1 ms, to: 100 ms, steps: 3, scale: log}\n"
      "seeds: 2\nfirst_seed: 7\n");
  EXPECT_EQ(sweep.points(), 6U);
  EXPECT_EQ(sweep.runs(), 12U);
  EXPECT_THAT(sweep.ValuesAt(0), ElementsAre("1 %", "1 ms"));
  EXPECT_THAT(sweep.ValuesAt(1), ElementsAre("1 %", "10 ms"));
  EXPECT_THAT(sweep.ValuesAt(5), ElementsAre("{b: [2, x y]}", "100 ms"));
  const Case last = sweep.CaseAt(11);
  EXPECT_EQ(last.point, 5U);
  EXPECT_EQ(last.seed, 8U);
  EXPECT_EQ(sweep.NameOf(sweep.CaseAt(0)), "point 1 (a: 1 %, c.d: 1 ms)");
}

TEST(SweepTest, NamesValuesAsTheFileDoes) {
  const Sweep sweep = SweepOf("axes:\n  - {key: a, values: {ours: {}, theirs: {b: 1}}}\n");
  EXPECT_THAT(sweep.ValuesAt(1), ElementsAre("{b: 1}"));
  EXPECT_EQ(sweep.NameOf(sweep.CaseAt(1)), "point 2 (a: theirs)");
  EXPECT_EQ(sweep.LabelOf(0, "{c: 2}"), "{c: 2}");
}

TEST(SweepTest, HoldsNoListOfPoints) {
  const std::string steps = ", from: 0, to: 1, steps: 10000}\n";
  const Sweep sweep = SweepOf("axes:\n  - {key: a" + steps + "  - {key: b" + steps + "seeds: 1000");
  EXPECT_EQ(sweep.runs(), 100'000'000'000U);
  EXPECT_THAT(sweep.ValuesAt(sweep.points() - 1), ElementsAre("1", "1"));
  const std::string c = "  - {key: c" + steps + "  - {key: d" + steps + "  - {key: e" + steps;
  EXPECT_THAT([&] { static_cast<void>(SweepOf("axes:\n  - {key: a" + steps + c)); },
              testing::Not(testing::Throws<InputError>()));
  EXPECT_THAT(
      [&] {
        static_cast<void>(
            SweepOf("axes:\n  - {key: a" + steps + "  - {key: b" + steps + c + "seeds: 1000"));
      },
      ThrowsMessage<InputError>(HasSubstr("more than 2^63 runs")));
}

TEST(SweepTest, DrawsForEachRunTheSameInAnyOrder) {
  const std::string text =
      "axes:\n"
      "  - {key: a, uniform: {from: 2 N, to: 3 N}}\n"
      "  - {key: b, values: [x, y]}\n"
      "seeds: 500\n";
  const Sweep sweep = SweepOf(text);
  std::set<std::string> drawn;
  for (std::uint64_t run = sweep.runs(); run-- > 0;) drawn.insert(sweep.CaseAt(run).values[0]);
  EXPECT_EQ(drawn.size(), 1000U);
  EXPECT_GE(*drawn.begin(), "2");
  EXPECT_LT(*drawn.rbegin(), "3");
  EXPECT_EQ(SweepOf(text).CaseAt(3).values, sweep.CaseAt(3).values);
  EXPECT_NE(SweepOf(text + "seed: 2\n").CaseAt(3).values, sweep.CaseAt(3).values);
  EXPECT_THAT(sweep.ValuesAt(1), ElementsAre("", "y"));
}

TEST(SweepTest, SamplesASobolSequenceEvenly) {
  const std::string axes =
      "axes:\n"
      "  - {key: a, from: 0, to: 4}\n"
      "  - {key: b, from: 4, to: 8}\n"
      "  - {key: c, uniform: {from: 0, to: 1}}\n"
      "samples: {kind: sobol, points: ";
  const Sweep sweep = SweepOf(axes + "16}\n");
  ASSERT_EQ(sweep.points(), 16U);
  std::set<std::pair<int, int>> cells;  // of 4 x 4, and of 16 x 1
  std::set<int> strips;
  for (std::uint64_t point = 0; point < 16; ++point) {
    const std::vector<std::string> values = sweep.ValuesAt(point);
    const double a = ParseNumber(values[0]);
    const double b = ParseNumber(values[1]);
    EXPECT_TRUE(a >= 0 && a < 4 && b >= 4 && b < 8) << a << ' ' << b;
    cells.emplace(static_cast<int>(a), static_cast<int>(b));
    strips.insert(static_cast<int>(a * 4));
  }
  EXPECT_EQ(cells.size(), 16U);
  EXPECT_EQ(strips.size(), 16U);
  EXPECT_EQ(SweepOf(axes + "1000}\n").ValuesAt(7),
            sweep.ValuesAt(7));  // more points keep the first
  EXPECT_NE(SweepOf(axes + "16}\nseed: 2\n").ValuesAt(7), sweep.ValuesAt(7));
}

TEST(SweepTest, RefusesAxesThatSayNothingClear) {
  const auto refuses = [](const std::string& axis, const std::string& says) {
    EXPECT_THAT([&] { static_cast<void>(SweepOf("axes:\n  - " + axis + "\n")); },
                ThrowsMessage<InputError>(HasSubstr(says)));
  };
  refuses("{key: a}", "give exactly one of");
  refuses("{key: a, values: [1], from: 1, to: 2, steps: 2}", "give exactly one of");
  refuses("{key: a, values: [1], steps: 2}", "steps goes with from");
  refuses("{key: a, from: 1 s, to: 2 ms, steps: 2}", "must have the same unit");
  refuses("{key: a, from: 2, to: 1, steps: 2}", "from must be below to");
  refuses("{key: a, from: 0, to: 1, steps: 2, scale: log}", "scale log takes from above 0");
  refuses("{key: a, from: 0, to: 1}", "a range in a grid needs steps");
  refuses("{key: a..b, values: [1]}", "with dots belongs here");
  refuses("{key: seed, values: [1]}", "say seeds and first_seed");
  refuses("{key: a, normal: {mean: 0, deviation: 0}}", "deviation must be above 0");
  refuses("{key: a, values: [1]}\n  - {key: a, values: [2]}", "key a has an axis already");
  refuses("{key: a.b, values: [1]}\n  - {key: a, values: [{}]}",
          "a replaces what the axis a.b says");
}

TEST(ShardTest, SharesEveryRunOutOnce) {
  const Sweep sweep = SweepOf("axes: [{key: a, values: [1, 2, 3]}]\nseeds: 5\n");
  EXPECT_EQ(RunsOf(sweep, {0, 7}) + RunsOf(sweep, {6, 7}), 5U);
  EXPECT_EQ(RunsOf(sweep, {0, 1}), 15U);
  EXPECT_EQ(RunsOf(sweep, {20, 21}), 0U);
  EXPECT_EQ(ParseShard("3/64").index, 3U);
  for (const char* text : {"", "3", "3/", "64/64", "-1/2", "1/2/3", "0/0"}) {
    EXPECT_THROW(static_cast<void>(ParseShard(text)), InputError) << text;
  }
}

// A point's draw depends on the profile and the point's number alone: shards agree on it.
TEST(SweepTest, PointsDrawFromTheProfilesCovariance) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "p.yaml")
      << "profile: 1\nrobot: panda\nscenario: {robot: {load: {mass: 1 kg}}}\n"
         "covariance: {keys: [robot.load.mass], matrix: [[0.01]]}\n";
  std::ofstream(folder / "base.yaml")
      << "name: base\nrobot: {profile: p.yaml}\nmotion:\n  trajectory:\n    unit: rad\n"
         "    waypoints:\n      - {q: [0, -0.8, 0, -2.4, 0, 1.6, 0.8]}\n"
         "      - {q: [0.1, -0.8, 0, -2.4, 0, 1.6, 0.8]}\n";
  const auto sweep_of = [&folder](const std::string& range) {
    std::ofstream(folder / "s.yaml")
        << "name: s\nscenario: base.yaml\naxes:\n  - {key: robot.profile_draw, " << range << "}\n";
    return Sweep(folder / "s.yaml", folder.path());
  };
  const Sweep sweep = sweep_of("from: 1, to: 50, steps: 50");
  sweep.CheckPoints();
  std::set<double> masses;
  for (std::uint64_t run = 0; run < sweep.runs(); ++run) {
    masses.insert(sweep.ScenarioOf(sweep.CaseAt(run)).robot.load.m_load);
  }
  EXPECT_EQ(masses.size(), 50U);
  const Sweep one = sweep_of("values: [7]");
  EXPECT_EQ(one.ScenarioOf(one.CaseAt(0)).robot.load, sweep.ScenarioOf(sweep.CaseAt(6)).robot.load);
}

}  // namespace
}  // namespace twin::sweep::sweep_points_test

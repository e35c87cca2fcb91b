#include "experiment/studies.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"
#include "experiment/loop_runs.h"
#include "experiment/runs.h"
#include "twin/core/error.h"
#include "twin/experiment/experiment.h"
#include "twin/experiment/page.h"

namespace twin::experiment::experiment_timings_test {
namespace {

using std::chrono::microseconds;
using test::ExperimentBench;
using ::testing::DoubleEq;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::SizeIs;

const Comparison& Of(const Findings& findings, const std::string& quantity) {
  const auto found = std::ranges::find(findings.comparisons, quantity, &Comparison::quantity);
  EXPECT_NE(found, findings.comparisons.end()) << quantity;
  return *found;
}

TEST(TimingsTest, ComparesTheTwelveFiguresOfTheTableAndTheirRatio) {
  const ExperimentBench bench;
  const Findings findings = RunTimings(bench.short_config());
  EXPECT_EQ(std::ranges::count_if(findings.comparisons,
                                  [](const Comparison& c) { return c.paper.has_value(); }),
            13);
  for (const Comparison& comparison : findings.comparisons) {
    EXPECT_LE(*comparison.low, *comparison.high) << comparison.quantity;
  }
  EXPECT_EQ(Of(findings, "RS, d_EXT, max").paper, 2.174);
  EXPECT_THAT(findings.figures, SizeIs(4));
  EXPECT_EQ(test::FiguresOnPage(findings, "timings"), 4U);
  for (const Figure& figure : findings.figures) {
    const auto columns = 1 + std::ranges::count(figure.columns, ',');
    EXPECT_THAT(figure.rows, Each(SizeIs(columns))) << figure.id;
  }
}

TEST(TimingsTest, WhatTheDelaysWereFittedToIsNoDemand) {
  const ExperimentBench bench;
  const Findings findings = RunTimings(bench.short_config(1));
  for (const char* loop : {"LF", "RS", "RA"}) {
    for (const char* figure : {"median", "p99"}) {
      const Comparison& fitted = Of(findings, fmt::format("{}, d_EXT, {}", loop, figure));
      EXPECT_EQ(fitted.verdict, Verdict::kCalibrated) << fitted.quantity;
      EXPECT_EQ(fitted.demand, "");
    }
    EXPECT_NE(Of(findings, fmt::format("{}, d_EXT, max", loop)).demand, "");
  }
  EXPECT_EQ(Of(findings, "LF, unserved cycles").verdict, Verdict::kCalibrated);
}

TEST(TimingsTest, TheSameSeedGivesTheSameBytesAndAnotherOthers) {
  const ExperimentBench bench;
  Config config = bench.short_config(1);
  const std::vector<Findings> first{RunTimings(config)};
  const std::vector<Findings> second{RunTimings(config)};
  config.seed = 2;
  const std::vector<Findings> other{RunTimings(config)};
  EXPECT_EQ(Page(first, {}), Page(second, {}));
  EXPECT_NE(Page(first, {}), Page(other, {}));
}

TEST(TimingsTest, VerdictsFollowTheDelays) {
  const ExperimentBench bench;
  const Config config = bench.short_config(1);
  std::string text = twin::test::ReadText(config.scenarios / "bare.yaml");
  text.replace(text.find("median: 12 us"), 13, "median: 60 us");
  std::ofstream(config.scenarios / "bare.yaml") << text;
  const Findings findings = RunTimings(config);
  EXPECT_EQ(Of(findings, "LF, d_EXT, max").verdict, Verdict::kNotReproduced);
  EXPECT_FALSE(findings.succeeded());
}

TEST(CalibrationTest, HashChangesWithAnyFigure) {
  const ExperimentBench bench;
  const Config config = bench.short_config();
  const std::string before = ReadCalibration(config.scenarios).hash;
  EXPECT_THAT(before, SizeIs(16));
  EXPECT_EQ(before, ReadCalibration(config.scenarios).hash);
  std::string text = twin::test::ReadText(config.scenarios / "asynchronous.yaml");
  const std::size_t sigma = text.find("sigma: 0.56151");
  ASSERT_NE(sigma, std::string::npos);
  text.replace(sigma, 14, "sigma: 0.56152");
  std::ofstream(config.scenarios / "asynchronous.yaml") << text;
  EXPECT_NE(before, ReadCalibration(config.scenarios).hash);
}

TEST(CalibrationTest, TheThreeLoopsHaveOneLinkAndOneMotion) {
  const ExperimentBench bench;
  const Config config = bench.config();
  const auto bare = LoadScenario(config, "bare");
  for (const CalibratedLoop& loop : kCalibratedLoops) {
    const auto scenario = LoadScenario(config, loop.file);
    EXPECT_EQ(scenario.link, bare.link) << loop.file;
    EXPECT_EQ(scenario.motion, bare.motion) << loop.file;
  }
}

// Two quantiles, two parameters: median m and p99 p make m exp(z ln(p / m) / z99). Nothing else.
TEST(CalibrationTest, LawsOfTheLoopsAreFittedToMedianAndP99Alone) {
  constexpr double kZ99 = 2.3263478740;  // standard normal
  const ExperimentBench bench;
  for (std::size_t i = 0; i < kCalibratedLoops.size(); ++i) {
    const auto scenario = LoadScenario(bench.config(), kCalibratedLoops[i].file);
    const bool in_tick = scenario.loop == loop::LoopKind::kAsynchronous;
    const scenario::Delay& cost = in_tick ? scenario.tick.cost : scenario.controller.cost;
    const auto* law = std::get_if<faults::LogNormalDelay>(&cost.law);
    ASSERT_NE(law, nullptr) << kCalibratedLoops[i].name;
    const double median_ms = 1e3 * ToSeconds(law->median);
    EXPECT_EQ(law->offset, Duration{});
    EXPECT_NEAR(median_ms, kTableOne[kMedianLatency].paper[i], 1e-9);
    EXPECT_NEAR(median_ms * std::exp(kZ99 * law->sigma) / kTableOne[kHighLatency].paper[i], 1,
                1e-3);
  }
}

// As long as a command takes little of a cycle, a state later than the rest of it is what LF leaves
// unserved: the share is that table's.
TEST(CalibrationTest, TheLateBinsWeightIsTheBareLoopsUnservedShare) {
  const ExperimentBench bench;
  const auto link = LoadScenario(bench.config(), "bare").link;
  const auto* law = std::get_if<faults::EmpiricalDelay>(&link.state.delay.law);
  ASSERT_NE(law, nullptr);
  const double sum = std::accumulate(law->weights.begin(), law->weights.end(), 0.0);
  EXPECT_NEAR(100 * law->weights.back() / sum, kTableOne[kUnserved].paper[0], 1e-9);
}

TEST(PercentileTest, IsTheSmallestValueWithAtLeastTheShareBelowIt) {
  const std::vector<double> values{1, 2, 3, 4};
  EXPECT_EQ(Percentile(values, 0), 1);
  EXPECT_EQ(Percentile(values, 0.5), 2);
  EXPECT_EQ(Percentile(values, 0.51), 3);
  EXPECT_EQ(Percentile(values, 1), 4);
}

TEST(HistogramTest, CountsBinsThatAreOpenAbove) {
  const std::vector<double> values{-1, 0, 0.5, 1, 2, 7};
  EXPECT_THAT(Histogram(values, std::vector<double>{0, 1, 2}),
              ElementsAre(DoubleEq(2.0 / 6), DoubleEq(1.0 / 6)));
  EXPECT_THAT(Histogram({}, std::vector<double>{0, 1}), ElementsAre(0));
}

TEST(SpreadTest, IsMeanAndExtremes) {
  const Spread spread = SpreadOf(std::vector<double>{3, 1, 5});
  EXPECT_EQ(spread.mean, 3);
  EXPECT_EQ(spread.low, 1);
  EXPECT_EQ(spread.high, 5);
}

/// @returns the largest difference of a draw from `factor` times that of the other, in ns.
double LargestDifference(const scenario::Delay& delay, double factor) {
  const auto model = delay.Model();
  const auto scaled = Scaled(delay, factor).Model();
  const Random random(1, RandomStream::kTest);
  double largest = 0;
  for (std::uint64_t tick = 0; tick < 500; ++tick) {
    const auto ns = static_cast<double>(model.Draw(random, tick).count());
    const auto scaled_ns = static_cast<double>(scaled.Draw(random, tick).count());
    largest = std::max(largest, std::abs(scaled_ns - factor * ns));
  }
  return largest;
}

TEST(ScaledDelayTest, TakesSoManyTimesAsLongInEveryDraw) {
  const std::vector<scenario::Delay> delays{
      {faults::ConstantDelay{microseconds(7)}},
      {faults::LogNormalDelay{microseconds(20), 0.5, microseconds(10)}},
      {faults::NormalDelay{microseconds(30), microseconds(8)}},
      {faults::GammaDelay{2, microseconds(10), microseconds(5)}},
      {faults::EmpiricalDelay{{microseconds(0), microseconds(10), microseconds(100)}, {3, 1}}}};
  for (const scenario::Delay& delay : delays) {
    EXPECT_LT(LargestDifference(delay, 2.5), 10) << "ns, of law " << delay.law.index();
  }
}

TEST(RunsTest, SeedsAndChoicesAreApartForEveryRun) {
  const ExperimentBench bench;
  const Config config = bench.config();
  std::set<std::uint64_t> seeds;
  std::set<double> choices;
  for (int run = 0; run < 100; ++run) {
    seeds.insert(SeedOfRun(config, run));
    for (const std::uint32_t what : {0U, 1U, 2U}) {
      const double choice = ChoiceOfRun(config, run, what);
      EXPECT_TRUE(choice >= 0 && choice < 1);
      choices.insert(choice);
    }
  }
  EXPECT_THAT(seeds, SizeIs(100));
  EXPECT_THAT(choices, SizeIs(300));
}

TEST(InParallelTest, DoesEveryJobOnceAndTellsFromTheCallersThread) {
  const ExperimentBench bench;
  Config config = bench.config();
  const auto caller = std::this_thread::get_id();
  double last = 0;
  config.progress = [&](double share) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    EXPECT_GE(share, last);
    last = share;
  };
  std::vector<int> done(100);
  InParallel(PartOf(config, 0.2, 0.7), 100,
             [&](int job) { ++done[static_cast<std::size_t>(job)]; });
  EXPECT_THAT(done, Each(1));
  EXPECT_EQ(last, 0.7);
}

TEST(InParallelTest, ThrowsWhatTheFirstJobInOrderThrew) {
  const ExperimentBench bench;
  const auto work = [](int job) {
    if (job >= 3) throw InputError("job " + std::to_string(job));
  };
  try {
    InParallel(bench.config(), 20, work);
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "job 3");
  }
}

TEST(RunScenarioTest, AnInterruptEndsAnExperiment) {
  const ExperimentBench bench;
  Config config = bench.short_config();
  const volatile bool interrupted = true;
  config.interrupted = &interrupted;
  EXPECT_THROW((void)RunTimings(config), RobotFault);
}

}  // namespace
}  // namespace twin::experiment::experiment_timings_test

#include "experiment/stream.h"
#include "experiment/studies.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "experiment/experiment_bench.h"

namespace twin::experiment::experiment_feed_forward_test {
namespace {

using test::ExperimentBench;

class FeedForwardStudyTest : public ::testing::Test {
 protected:
  [[nodiscard]] StreamRuns Run(VelocityFrom velocity, double jitter_s, double ppm) const {
    return RunFeedForward(bench_.config(), streams_.canonical, streams_.robot.limits, velocity,
                          jitter_s, ppm, 2);
  }

  const ExperimentBench bench_;
  const StreamInputs streams_ = LoadStreamInputs(bench_.config());
};

TEST_F(FeedForwardStudyTest, OverTheSourcesTimeNeitherJitterNorCrossingsAbort) {
  for (const double ppm : {0.0, 50.0}) {
    const StreamRuns runs = Run(VelocityFrom::kSourceTime, 4e-6, ppm);
    EXPECT_EQ(runs.aborted, 0) << ppm << " ppm";
    EXPECT_LT(runs.jerk, 1) << ppm << " ppm";
  }
}

TEST_F(FeedForwardStudyTest, OverTheNominalPeriodJitterAbortsAndACrossingAloneDoesNot) {
  EXPECT_EQ(Run(VelocityFrom::kNominalTime, 4e-6, 0).aborted, 1);
  EXPECT_EQ(Run(VelocityFrom::kNominalTime, 0, 50).aborted, 0);
}

TEST_F(FeedForwardStudyTest, WhereConsumedEveryCrossingAborts) {
  EXPECT_EQ(Run(VelocityFrom::kConsumption, 0, 0).aborted, 0);
  EXPECT_EQ(Run(VelocityFrom::kConsumption, 0, 50).aborted, 1);
  EXPECT_EQ(Run(VelocityFrom::kConsumption, 4e-6, 50).aborted, 1);
}

TEST_F(FeedForwardStudyTest, WhereConsumedASkippedDepositIsTwiceTheVelocityForACycle) {
  const reference::Trajectory plan = SecondOfMotion({1 / 1.875}, streams_.robot.limits);
  Stream stream{.velocity = VelocityFrom::kConsumption, .clock_ppm = 100};
  stream.tick.generator = loop::Generator::kJoint;
  stream.phase = std::chrono::nanoseconds(50'000);  // crosses at 0.5 s, at 1 rad/s
  double largest = 0;
  static_cast<void>(RunStream(plan, streams_.robot.limits, stream, false,
                              [&](std::uint64_t, const onboard::JointReference& next) {
                                largest = std::max(largest, next.dq_d[0]);
                              }));
  EXPECT_NEAR(largest, 2, 0.01);
}

TEST_F(FeedForwardStudyTest, MeetsWhatItDemandsAndDrawsATableAndACrossing) {
  const Findings findings = RunFeedForwardStudy(bench_.config(1));
  EXPECT_TRUE(findings.succeeded());
  ASSERT_EQ(findings.figures.size(), 2U);
  EXPECT_EQ(findings.figures[0].rows.size(), 36U);
  EXPECT_EQ(test::FiguresOnPage(findings, "feed_forward"), 2U);
}

}  // namespace
}  // namespace twin::experiment::experiment_feed_forward_test

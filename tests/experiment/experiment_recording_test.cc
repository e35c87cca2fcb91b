#include "experiment/runs.h"
#include "experiment/statistics.h"

#include <vector>

#include <gtest/gtest.h>

#include "twin/scenario/robot_data.h"

namespace twin::experiment::experiment_recording_test {
namespace {

reference::Trajectory Plan() {
  const JointVector q{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
  JointVector there = q;
  there[0] = 0.4;
  there[5] = 1.9;
  return {{{.q = q}, {.q = there}, {.q = q}},
          {.duration = std::chrono::seconds(5)},
          scenario::LoadRobotData(std::filesystem::path(TWIN_SOURCE_DIR) / "models", "panda",
                                  plant::HandKind::kFrankaHand)
              .limits};
}

/// The plan itself, late by `delay_s`, with an offset on joint 3.
std::vector<CycleSample> Follow(const reference::Trajectory& plan, double delay_s, double offset) {
  std::vector<CycleSample> cycles;
  for (int k = 0; k < 5000; ++k) {
    CycleSample sample;
    sample.q = plan.Sample(FromSeconds(k * 1e-3 - delay_s)).q;
    sample.q[2] += offset;
    cycles.push_back(sample);
  }
  return cycles;
}

TEST(RecordingTest, KeepsCyclesInMotionAndTicksThatWrote) {
  Recording recording;
  recording.Put(record::CycleRecord{});
  record::CycleRecord served;
  served.fate = record::CommandFate::kServed;
  served.state.dq_d[1] = 0.5;
  recording.Put(served);
  record::TickRecord skipped;
  skipped.action = record::TickAction::kSkipped;
  recording.Put(skipped);
  ASSERT_EQ(recording.cycles().size(), 1U);
  EXPECT_EQ(recording.cycles()[0].dq_d[1], 0.5);
  EXPECT_TRUE(recording.ticks().empty());
}

TEST(RecordingTest, FindsTheDelayOfAMotion) {
  const reference::Trajectory plan = Plan();
  for (const double delay_s : {-0.002, 0.0035, 0.03}) {
    EXPECT_NEAR(DelayBehind(plan, Follow(plan, delay_s, 0), &CycleSample::q), delay_s, 1e-7);
  }
}

TEST(RecordingTest, WhatADelayDoesNotExplainIsTheError) {
  const reference::Trajectory plan = Plan();
  const std::vector<CycleSample> cycles = Follow(plan, 0.01, 2e-3);
  const double delay_s = DelayBehind(plan, cycles, &CycleSample::q);
  const JointVector rms = RmsError(plan, cycles, &CycleSample::q, delay_s);
  EXPECT_NEAR(rms[2], 2e-3, 1e-9);
  EXPECT_LT(rms[0], 1e-7);
}

TEST(RecordingTest, TheRegressionSlopeIsTheShareThatIsFollowed) {
  EXPECT_DOUBLE_EQ(RegressionSlope({0, 1, 2, 3}, {5, 5.4, 5.8, 6.2}), 0.4);
}

}  // namespace
}  // namespace twin::experiment::experiment_recording_test

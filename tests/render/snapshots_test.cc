#include "twin/render/snapshots.h"

#include <gtest/gtest.h>

#include "render/test_model.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::render::snapshots_test {
namespace {

using std::chrono::milliseconds;

/// Runs `duration` at 1 ms, with qpos[0] = the time in ms.
void RunMilliseconds(int duration_ms, TestModel& model, SnapshotRecorder& recorder) {
  for (int t = 0; t <= duration_ms; ++t) {
    model.SetQpos(0, t);
    recorder.Capture(Time(milliseconds(t)), model);
  }
}

TEST(SnapshotRecorderTest, CapturesEveryFrameThatIsDueBothEndsIncluded) {
  TestModel model(kArmMjcf);
  SnapshotRecorder recorder(milliseconds(1000), 25, model.qpos_size());
  RunMilliseconds(1000, model, recorder);
  const Snapshots& snapshots = recorder.snapshots();
  ASSERT_EQ(snapshots.size(), 26U);
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    EXPECT_EQ(snapshots.time(i), Time(milliseconds(40 * i)));
    EXPECT_EQ(snapshots.qpos(i)[0], 40.0 * static_cast<double>(i));
    EXPECT_EQ(snapshots.qpos(i).size(), model.qpos_size());
  }
}

TEST(SnapshotRecorderTest, KeepsPaceWhenTheFrameTimeIsNoWholeNumberOfCycles) {
  TestModel model(kArmMjcf);
  SnapshotRecorder recorder(std::chrono::seconds(10), 30, model.qpos_size());
  RunMilliseconds(10000, model, recorder);
  const Snapshots& snapshots = recorder.snapshots();
  ASSERT_EQ(snapshots.size(), 301U);
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    // The first cycle at or after i / 30 s.
    EXPECT_EQ(snapshots.time(i), Time(milliseconds((1000 * i + 29) / 30)));
  }
}

TEST(SnapshotRecorderTest, RepeatsTheFrameForEachThatALateCallMissed) {
  TestModel model(kArmMjcf);
  SnapshotRecorder recorder(milliseconds(200), 25, model.qpos_size());
  recorder.Capture(Time(milliseconds(0)), model);
  model.SetQpos(0, 7);
  recorder.Capture(Time(milliseconds(130)), model);  // frames due at 40, 80 and 120
  const Snapshots& snapshots = recorder.snapshots();
  ASSERT_EQ(snapshots.size(), 4U);
  EXPECT_EQ(snapshots.qpos(0)[0], 0);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(snapshots.qpos(i)[0], 7);
    EXPECT_EQ(snapshots.time(i), Time(milliseconds(130)));
  }
}

TEST(SnapshotRecorderTest, CountsFromItsFirstCall) {
  TestModel model(kArmMjcf);
  SnapshotRecorder recorder(milliseconds(100), 25, model.qpos_size());
  recorder.Capture(Time(milliseconds(7)), model);
  recorder.Capture(Time(milliseconds(46)), model);
  EXPECT_EQ(recorder.snapshots().size(), 1U);
  recorder.Capture(Time(milliseconds(47)), model);
  EXPECT_EQ(recorder.snapshots().size(), 2U);
}

TEST(SnapshotRecorderTest, NeverGrowsBeyondItsStorage) {
  TestModel model(kArmMjcf);
  SnapshotRecorder recorder(milliseconds(100), 25, model.qpos_size());
  recorder.Capture(Time(milliseconds(0)), model);
  const double* const storage = recorder.snapshots().qpos(0).data();
  RunMilliseconds(1000, model, recorder);
  EXPECT_EQ(recorder.snapshots().size(), 3U);
  EXPECT_EQ(recorder.snapshots().qpos(0).data(), storage);
}

TEST(SnapshotRecorderTest, WithoutAVideoToMakeItKeepsTheLastSceneOnly) {
  TestModel model(kArmMjcf);
  using Keep = SnapshotRecorder::Keep;
  SnapshotRecorder all(milliseconds(200), 25, model.qpos_size());
  SnapshotRecorder last(milliseconds(200), 25, model.qpos_size(), Keep::kLast);
  for (const int now : {0, 30, 40, 130, 200, 500}) {
    model.SetQpos(0, now);
    EXPECT_EQ(last.Capture(Time(milliseconds(now)), model),
              all.Capture(Time(milliseconds(now)), model))
        << now;
    EXPECT_EQ(last.last().Positions()[0], all.last().Positions()[0]) << now;
  }
  EXPECT_EQ(all.snapshots().size(), 6U);
  EXPECT_EQ(last.snapshots().size(), 0U);
}

TEST(SnapshotRecorderTest, NeitherAllocatesNorLocksFromTheFirstCaptureOn) {
  TestModel model(kArmMjcf);
  SnapshotRecorder recorder(milliseconds(1000), 25, model.qpos_size());
  const test::RealtimeGuard guard;
  RunMilliseconds(1500, model, recorder);
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

TEST(SnapshotRecorderTest, RefusesFrameRatesAndDurationsOutOfRange) {
  EXPECT_THROW(SnapshotRecorder(milliseconds(1), 0, 1), InputError);
  EXPECT_THROW(SnapshotRecorder(milliseconds(1), 1001, 1), InputError);
  EXPECT_THROW(SnapshotRecorder(milliseconds(-1), 25, 1), InputError);
}

}  // namespace
}  // namespace twin::render::snapshots_test

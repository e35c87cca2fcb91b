#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "record/arm_frames.h"
#include "record/log_fields.h"
#include "record/sample_records.h"
#include "record/temporary_folder.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/record/log_reader.h"
#include "twin/record/mcap_reader.h"
#include "twin/record/recorder.h"

namespace twin::record::record_frames_test {
namespace {

using std::chrono::milliseconds;

/// Rotation and translation of a frame in its parent, by the textbook's formula.
Transform PoseOf(const foxglove::FrameTransform& frame) {
  const double x = frame.rotation().x();
  const double y = frame.rotation().y();
  const double z = frame.rotation().z();
  const double w = frame.rotation().w();
  return {1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),     0,
          2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),     0,
          2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y), 0,
          frame.translation().x(), frame.translation().y(), frame.translation().z(), 1};
}

void ExpectNear(const Transform& actual, const Transform& expected) {
  for (std::size_t i = 0; i < actual.size(); ++i) EXPECT_NEAR(actual[i], expected[i], 1e-12) << i;
}

/// Random angles over two turns each.
JointVector SomeAngles(std::uint64_t number) {
  const Random random(7, RandomStream::kTest);
  JointVector q{};
  for (std::uint32_t i = 0; i < kJoints; ++i) q[i] = 12.6 * random.Uniform(number, i) - 6.3;
  return q;
}

/// Frames of one cycle.
foxglove::FrameTransforms FramesAt(const JointVector& q) {
  ArmFrames frames;
  const foxglove::FrameTransforms* message = frames.Next(Time(), q);
  return message == nullptr ? foxglove::FrameTransforms() : *message;
}

/// Frames of a sample cycle.
foxglove::FrameTransforms FramesOfCycle(std::uint64_t k) {
  const record::CycleRecord cycle = SampleCycle(k);
  ArmFrames frames;
  return *frames.Next(cycle.at, cycle.state.q);
}

TEST(ArmFramesTest, FormAChainFromTheBaseToTheHand) {
  const foxglove::FrameTransforms message = FramesAt({});
  ASSERT_EQ(message.transforms_size(), 9);
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(message.transforms(i).parent_frame_id(), "panda_link" + std::to_string(i));
    EXPECT_EQ(message.transforms(i).child_frame_id(),
              i == 8 ? "panda_hand" : "panda_link" + std::to_string(i + 1));
  }
}

TEST(ArmFramesTest, LeadToTheFlangeOfTheModel) {
  const auto& arm = model::ArmModel::Panda();
  for (std::uint64_t number = 0; number < 500; ++number) {
    const JointVector q = SomeAngles(number);
    const foxglove::FrameTransforms message = FramesAt(q);
    Transform O_T_link = kIdentityTransform;
    for (int i = 0; i < 8; ++i) {
      const foxglove::FrameTransform& frame = message.transforms(i);
      O_T_link = model::Multiply(O_T_link, PoseOf(frame));
      EXPECT_GE(frame.rotation().w(), 0);
    }
    ExpectNear(O_T_link, arm.Pose(model::Frame::kFlange, q));
    ASSERT_FALSE(HasFailure()) << "angles " << number;
  }
}

TEST(ArmFramesTest, TurnEachJointByItsOwnAngle) {
  for (const double angle : {0.0, 1e-9, 1.0, -1.0, 3.141592653589793, 3.0, -3.1, 6.2}) {
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      JointVector q{};
      const Transform before = PoseOf(FramesAt(q).transforms(static_cast<int>(joint)));
      q[joint] = angle;
      const Transform after = PoseOf(FramesAt(q).transforms(static_cast<int>(joint)));
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      ExpectNear(after, model::Multiply(before, {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}));
    }
  }
}

TEST(ArmFramesTest, HoldTheHandTurnedByMinusFortyFiveDegreesAtTheFlange) {
  const double c = std::sqrt(0.5);
  ExpectNear(PoseOf(FramesAt(SomeAngles(1)).transforms(8)),
             {c, -c, 0, 0, c, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
}

TEST(ArmFramesTest, AreDueOnceInEachSpanOfTwentyMilliseconds) {
  ArmFrames frames;
  std::vector<std::int64_t> given;
  for (int k = 1; k <= 100; ++k) {
    if (const auto* message = frames.Next(Time(milliseconds(k)), {})) {
      given.push_back(k);
      EXPECT_EQ(message->transforms(3).timestamp().nanos(), k * 1'000'000);
    }
  }
  EXPECT_THAT(given, ::testing::ElementsAre(1, 20, 40, 60, 80, 100));
}

TEST(ArmFramesTest, KeepTheirRateWhenCyclesAreMissing) {
  ArmFrames frames;
  std::vector<int> given;
  for (const int k : {0, 19, 21, 22, 39, 95, 96, 119, 120, 2001}) {
    if (frames.Next(Time(milliseconds(k)), {}) != nullptr) given.push_back(k);
  }
  EXPECT_THAT(given, ::testing::ElementsAre(0, 21, 95, 119, 120, 2001));
}

TEST(ArmFramesTest, LeaveOutAnglesThatAreNoNumbers) {
  ArmFrames frames;
  JointVector q{};
  q[6] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(frames.Next(Time(), q), nullptr);
  q[6] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(frames.Next(Time(milliseconds(1)), q), nullptr);
  EXPECT_NE(frames.Next(Time(milliseconds(2)), {}), nullptr) << "the span still has none";
}

TEST(ArmFramesTest, CountTheirTimeInSecondsAndTheRest) {
  ArmFrames frames;
  const auto* message = frames.Next(Time(milliseconds(12'345)), {});
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->transforms(8).timestamp().seconds(), 12);
  EXPECT_EQ(message->transforms(8).timestamp().nanos(), 345'000'000);
}

TEST(RecorderTest, WritesTheFramesOfTheMeasuredPositionsBehindTheirCycles) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  for (std::uint64_t k = 0; k < 1000; ++k) recorder.Put(SampleCycle(k));
  recorder.Finish();

  McapReader reader(folder / "a.mcap");
  std::uint64_t count = 0;
  std::uint64_t last_cycle = 0;
  while (const auto message = reader.Next()) {
    if (message->channel->topic == kCycleTopic) last_cycle = message->log_time_ns;
    if (message->channel->topic != kFramesTopic) continue;
    EXPECT_EQ(message->channel->schema_name, "foxglove.FrameTransforms");
    EXPECT_EQ(message->channel->message_encoding, "protobuf");
    EXPECT_EQ(message->log_time_ns, last_cycle);
    foxglove::FrameTransforms frames;
    ASSERT_TRUE(
        frames.ParseFromArray(message->data.data(), static_cast<int>(message->data.size())));
    EXPECT_EQ(frames.SerializeAsString(), FramesOfCycle(20 * count).SerializeAsString());
    ++count;
  }
  EXPECT_EQ(count, 50U);
}

TEST(LogReaderTest, PassesOverTheFrames) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  for (std::uint64_t k = 0; k < 100; ++k) recorder.Put(SampleCycle(k));
  recorder.Finish();
  LogReader reader(folder / "a.mcap");
  LogEntry entry;
  std::uint64_t cycles = 0;
  while (reader.Next(entry)) cycles += std::holds_alternative<record::CycleRecord>(entry) ? 1 : 0;
  EXPECT_EQ(cycles, 100U);
  EXPECT_EQ(reader.message_count(), 100U + 1 + SampleFrames(100));
}

}  // namespace
}  // namespace twin::record::record_frames_test

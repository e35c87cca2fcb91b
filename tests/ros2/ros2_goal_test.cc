#include <cmath>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fuzz/mutations.h"
#include "plugins/ros2/cdr.h"
#include "plugins/ros2/franka_state.h"
#include "plugins/ros2/lockstep_answers.h"
#include "plugins/ros2/robot_description.h"
#include "plugins/ros2/rtps_gate.h"
#include "plugins/ros2/state_tap.h"
#include "plugins/ros2/trajectory_goal.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::ros2::ros2_goal_test {
namespace {

using ::testing::HasSubstr;

constexpr JointVector kReady{0, -0.785, 0, -2.356, 0, 1.571, 0.785};

GoalContext Context() {
  return {.names = NamesOf("panda_joint"),
          .limits = test::PandaLimits(),
          .q_d = kReady,
          .now = Time(std::chrono::seconds(1000))};
}

msg::JointTrajectoryPoint PointAt(double seconds, double by) {
  msg::JointTrajectoryPoint point;
  for (const double q : kReady) point.positions.push_back(q + by);
  const auto whole = static_cast<std::int32_t>(seconds);
  point.time_from_start = {.sec = whole,
                           .nanosec = static_cast<std::uint32_t>((seconds - whole) * 1e9)};
  return point;
}

/// Two seconds, 0.1 rad.
FollowJointTrajectory::Goal Sound() {
  FollowJointTrajectory::Goal goal;
  for (const std::string& name : Context().names) goal.trajectory.joint_names.push_back(name);
  goal.trajectory.points = {PointAt(0, 0), PointAt(1, 0.05), PointAt(2, 0.1)};
  return goal;
}

/// Of a sound one after a change.
GoalRefusal RefusalAfter(const std::function<void(FollowJointTrajectory::Goal&)>& change) {
  FollowJointTrajectory::Goal goal = Sound();
  change(goal);
  const auto read = ReadGoal(goal, Context());
  const auto* refusal = std::get_if<GoalRefusal>(&read);
  return refusal != nullptr ? *refusal : GoalRefusal{.why = "accepted"};
}

JointGoal Accepted(const FollowJointTrajectory::Goal& goal) {
  auto read = ReadGoal(goal, Context());
  if (const auto* refusal = std::get_if<GoalRefusal>(&read)) ADD_FAILURE() << refusal->why;
  return std::get<JointGoal>(std::move(read));
}

TEST(Ros2Goal, BecomesAPathThroughItsPoints) {
  const JointGoal goal = Accepted(Sound());
  EXPECT_EQ(goal.trajectory.duration(), std::chrono::seconds(2));
  EXPECT_NEAR(goal.trajectory.Sample(std::chrono::seconds(1)).q[3], kReady[3] + 0.05, 1e-9);
  EXPECT_TRUE(std::isinf(goal.path.position[0]));
}

TEST(Ros2Goal, BeginsWhereTheArmIs) {
  FollowJointTrajectory::Goal goal = Sound();
  goal.trajectory.points.erase(goal.trajectory.points.begin());  // the first is at 1 s
  EXPECT_EQ(Accepted(goal).trajectory.start(), kReady);
  goal = Sound();
  for (auto& point : goal.trajectory.points) point.positions[2] += 0.015;
  EXPECT_NEAR(Accepted(goal).offset[2], 0.015, 1e-12);
}

TEST(Ros2Goal, KeepsTheVelocitiesOfFewPoints) {
  FollowJointTrajectory::Goal goal = Sound();
  goal.trajectory.points = {PointAt(0, 0), PointAt(1, 0.05), PointAt(2, 0.1)};
  for (auto& point : goal.trajectory.points) point.velocities.assign(7, 0);
  // At rest in the middle; a path through the positions alone would pass it.
  const JointGoal stops = Accepted(goal);
  EXPECT_NEAR(stops.trajectory.Sample(std::chrono::seconds(1)).dq[0], 0, 2e-3);
  goal.trajectory.points[1].velocities.assign(7, 0.08);
  EXPECT_NEAR(Accepted(goal).trajectory.Sample(std::chrono::seconds(1)).dq[0], 0.08, 2e-3);
}

TEST(Ros2Goal, SaysWhatIsWrong) {
  const auto refusal = [](auto change) { return RefusalAfter(change); };
  using Goal = FollowJointTrajectory::Goal;
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points.clear(); }).why, HasSubstr("no points"));
  const GoalRefusal names = refusal([](Goal& g) { g.trajectory.joint_names[0] = "elbow"; });
  EXPECT_EQ(names.code, FollowJointTrajectory::kInvalidJoints);
  EXPECT_THAT(names.why, HasSubstr("panda_joint1"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points[1].positions.pop_back(); }).why,
              HasSubstr("points[1].positions has 6 values"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points[1].velocities = {1}; }).why,
              HasSubstr("points[1].velocities has 1 values"));
  EXPECT_THAT(refusal([](Goal& g) {
                g.trajectory.points[1].accelerations.assign(
                    7, std::numeric_limits<double>::infinity());
              }).why,
              HasSubstr("not finite"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points[2].time_from_start.sec = 0; }).why,
              HasSubstr("points[2].time_from_start"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points[0].time_from_start.sec = -1; }).why,
              HasSubstr("points[0].time_from_start"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points.resize(1); }).why,
              HasSubstr("leaves the arm no time"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points[1].positions[3] = 0; }).why,
              HasSubstr("joint 4"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points[0].positions[0] += 0.03; }).why,
              HasSubstr("Plan from where the arm is"));
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.points[1].positions[0] += 2; }).why,
              HasSubstr("limit"));
  EXPECT_THAT(refusal([](Goal& g) { g.path_tolerance = {{.name = "elbow"}}; }).why,
              HasSubstr("path_tolerance names elbow"));
  EXPECT_THAT(refusal([](Goal& g) { g.multi_dof_trajectory.points.resize(1); }).why,
              HasSubstr("multi_dof"));
  const GoalRefusal old = refusal([](Goal& g) { g.trajectory.header.stamp.sec = 990; });
  EXPECT_EQ(old.code, FollowJointTrajectory::kOldHeaderTimestamp);
  EXPECT_THAT(refusal([](Goal& g) { g.trajectory.header.stamp.sec = 1010; }).why,
              HasSubstr("in the future"));
}

TEST(Ros2Goal, TolerancesAreThoseOfTheMessage) {
  FollowJointTrajectory::Goal goal = Sound();
  goal.goal_tolerance = {{.name = "panda_joint2", .position = 0.01},
                         {.name = "panda_joint3", .position = -1}};
  goal.goal_time_tolerance = {.sec = 2, .nanosec = 500'000'000};
  const JointGoal read = Accepted(goal);
  EXPECT_EQ(read.end.position[1], 0.01);
  EXPECT_TRUE(std::isinf(read.end.position[2]));
  EXPECT_EQ(read.end_time, std::chrono::milliseconds(2500));
}

TEST(Ros2Goal, MutatedGoalsAreReadOrRefused) {
  const std::vector<std::byte> whole =
      ToBytes(SendGoal<FollowJointTrajectory>::Request{.goal_id = {}, .goal = Sound()});
  const Random random(11, RandomStream::kTest);
  int accepted = 0;
  int refused = 0;
  for (std::uint64_t round = 0; round < 3000; ++round) {
    std::vector<std::byte> bytes = whole;
    fci::fuzz::Mutate(bytes, random, round);
    const auto request = FromBytes<SendGoal<FollowJointTrajectory>::Request>(bytes);
    if (!request) continue;
    const auto read = ReadGoal(request->goal, Context());
    const auto* refusal = std::get_if<GoalRefusal>(&read);
    ++(refusal == nullptr ? accepted : refused);
    EXPECT_FALSE(refusal != nullptr && refusal->why.empty());
  }
  EXPECT_GT(accepted, 0);
  EXPECT_GT(refused, 0);
}

TEST(Ros2Franka, ErrorsHaveTheRobotsNames) {
  int known = 0;
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    RobotState state;
    state.errors.set(i);
    msg::Errors errors = ToFrankaState(state, {}, NamesOf("panda_joint")).current_errors;
    int raised = 0;
    msg::Errors::Visit(errors, [&](std::string_view name, bool is_raised) {
      if (!is_raised) return;
      ++raised;
      const std::string_view ours = Name(static_cast<RobotError>(i));
      EXPECT_TRUE(name == ours || name == "tau_j_range_violation" ||
                  name == "cartesian_position_motion_generator_invalid_frame")
          << name << " for " << ours;
    });
    known += raised;
  }
  EXPECT_EQ(known, 36);  // all that the message has
}

TEST(Ros2Description, HasArmAndHand) {
  const std::string models = TWIN_SOURCE_DIR "/models";
  const std::string arm = models + "/robots/panda/panda.urdf";
  const std::string whole = DescriptionOf(arm, models + "/robots/hand/hand.urdf");
  EXPECT_THAT(whole, HasSubstr("panda_finger_joint2"));
  EXPECT_EQ(whole.find("<link name=\"panda_link8\""), whole.rfind("<link name=\"panda_link8\""));
  EXPECT_THAT(DescriptionOf(arm, {}), ::testing::Not(HasSubstr("finger")));
  EXPECT_THROW(static_cast<void>(DescriptionOf(models + "/robots/panda/limits.yaml", {})),
               InputError);
}

std::vector<std::byte> Datagram(std::initializer_list<int> body) {
  std::vector<std::byte> bytes{std::byte{'R'}, std::byte{'T'}, std::byte{'P'}, std::byte{'S'}};
  bytes.resize(20);
  for (const int byte : body) bytes.push_back(static_cast<std::byte>(byte));
  return bytes;
}

TEST(Ros2RtpsGate, DdsReadsWholeKnownSubmessages) {
  EXPECT_EQ(ReadableBytes({}), 0U);
  EXPECT_EQ(ReadableBytes(Datagram({})), 0U);
  // INFO_TS without a time, then a statistics submessage of eProsima's, which is left out.
  EXPECT_EQ(ReadableBytes(Datagram({0x09, 3, 0, 0, 0x80, 1, 4, 0, 1, 2, 3, 4})), 24U);
  // INFO_DST of 12 bytes, big endian; the same cut.
  const auto whole = Datagram({0x0e, 0, 0, 12, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  EXPECT_EQ(ReadableBytes(whole), whole.size());
  EXPECT_EQ(ReadableBytes(std::span(whole).first(whole.size() - 1)), 0U);
  auto other = whole;
  other[0] = std::byte{'X'};
  EXPECT_EQ(ReadableBytes(other), 0U);
}

TEST(Ros2RtpsGate, DdsStepsThroughNoThousandYearsOfSamples) {
  std::vector<std::byte> heartbeat = Datagram({0x07, 1, 28, 0});
  heartbeat.resize(24 + 28);
  EXPECT_EQ(ReadableBytes(heartbeat), heartbeat.size());
  heartbeat[24 + 16] = std::byte{1};  // the last sample's number is above 2^32
  EXPECT_EQ(ReadableBytes(heartbeat), 0U);
}

TEST(Ros2StateTap, CostsTheRobotNoMemoryAndNoLock) {
  StateTap tap(nullptr);
  record::CycleRecord record;
  const test::RealtimeGuard guard;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    record.at += kCycle;
    tap.Put(record);
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
  EXPECT_EQ(tap.dropped(), 1000 - 256);  // nobody took them
  EXPECT_EQ(tap.last_at(), Time(1000 * kCycle));
  int taken = 0;
  while (tap.TryPop([&](const record::CycleRecord&) { ++taken; })) {
  }
  EXPECT_EQ(taken, 256);
}

TEST(Ros2Lockstep, WaitsForAnAnswerToTheState) {
  LockstepAnswers answers;
  const Time stamp{std::chrono::milliseconds(10)};
  answers.Put({.q = {}, .sampled_at = Time(std::chrono::milliseconds(9))});
  EXPECT_FALSE(answers.Await(stamp, std::chrono::milliseconds(1)));
  std::jthread node([&] { answers.Put({.q = kReady, .sampled_at = stamp}); });
  const auto answer = answers.Await(stamp, std::chrono::minutes(1));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->q, kReady);
  answers.Stop();
  EXPECT_FALSE(answers.Await(stamp, std::chrono::minutes(1)));
}

}  // namespace
}  // namespace twin::ros2::ros2_goal_test

#include "twin/planning/pose_following.h"

#include <chrono>
#include <cmath>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "controllers/cartesian_pose.h"
#include "planning/planning_fixture.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"

namespace twin::planning::planning_pose_following_test {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1ms

Transform PoseAt(const JointVector& q) {
  return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q);
}

Transform Moved(Transform X, double x, double y, double z) {
  X[12] += x;
  X[13] += y;
  X[14] += z;
  return X;
}

reference::PoseTrajectory Path(const std::vector<Transform>& poses, double pace = 0.2) {
  std::vector<reference::PoseWaypoint> waypoints;
  waypoints.reserve(poses.size());
  for (const Transform& pose : poses) waypoints.push_back({.O_T_EE = pose});
  return reference::PoseTrajectory(
      waypoints, {.velocity_scale = pace, .acceleration_scale = pace, .jerk_scale = pace},
      test::PandaCartesianLimits());
}

std::variant<Followed, std::string> FollowFromReady(const reference::PoseTrajectory& path) {
  return Follow(path, kReady, kIdentityTransform, test::PandaLimits());
}

TEST(PoseFollowingTest, GoesWhereTheControllerGoes) {
  const Transform start = PoseAt(kReady);
  const auto path = Path({start, Moved(start, 0.1, 0.3, -0.2), Moved(start, 0.2, -0.2, 0)});
  const auto outcome = FollowFromReady(path);
  ASSERT_TRUE(std::holds_alternative<Followed>(outcome));
  const std::vector<JointVector>& way = std::get<Followed>(outcome).q;

  const JointLimits limits = test::PandaLimits();
  const reference::Trajectory stand({{.q = kReady, .at = 0s}, {.q = kReady, .at = path.duration()}},
                                    {}, limits);
  controllers::CartesianPoseController controller({.trajectory = stand,
                                                   .poses = &path,
                                                   .limits = limits,
                                                   .cartesian = test::PandaCartesianLimits()});
  RobotState state;
  state.q = state.q_d = kReady;
  controller.Activate(state, Time(0s));
  control::ControllerOutput output;
  for (Duration t{}; !output.finished && t < path.duration() + 5s; t += 1ms) {
    controller.Update(state, Time(t), output);
    if (t % 500ms != 0ms) continue;
    const JointVector& q = way.at(static_cast<std::size_t>(t / 5ms));
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(output.target.joint.q[i], q[i], 1e-3) << i << " at " << ToSeconds(t);
    }
  }
  ASSERT_TRUE(output.finished);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(output.target.joint.q[i], way.back()[i], 1e-3) << i;
  }
}

TEST(PoseFollowingTest, TellsWhatOfTheLimitsIsUsed) {
  const Transform start = PoseAt(kReady);
  const std::vector<Transform> poses{start, Moved(start, 0, 0.3, 0)};
  const auto slow = std::get<Followed>(FollowFromReady(Path(poses, 0.1)));
  const auto fast = std::get<Followed>(FollowFromReady(Path(poses, 0.9)));
  EXPECT_LT(slow.velocity_load, 0.5);
  EXPECT_GT(fast.velocity_load, 1) << "1.5 m/s is more than half of what the joints do";
  EXPECT_GT(fast.acceleration_load, 1);
  // The same way, whatever the pace; only the correction's share of it differs.
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(slow.q.back()[i], fast.q.back()[i], 5e-3);
}

TEST(PoseFollowingTest, NamesTheJointThatLeavesItsRange) {
  const Transform start = PoseAt(kReady);
  // Down beside its own base: the elbow closes.
  const auto near = FollowFromReady(Path({start, Moved(start, -0.15, 0, -0.3)}));
  ASSERT_TRUE(std::holds_alternative<std::string>(near));
  EXPECT_THAT(std::get<std::string>(near), HasSubstr("joint 4 comes to"));
}

TEST(PoseFollowingTest, SaysWhenTheGoalIsOutOfReach) {
  const Transform start = PoseAt(kReady);
  const auto far = FollowFromReady(Path({start, Moved(start, 0.7, 0, 0)}));
  EXPECT_TRUE(std::holds_alternative<std::string>(far));
}

TEST(PoseFollowingTest, FindsWhatIsTouchedOnTheWayBetweenFreeEnds) {
  CollisionWorld world(Options("table_box.xml"));
  std::vector<JointVector> way;
  const auto at = [](double y) { return Reaching(Down(0.5, y, 0.43)); };
  // Past the box at the height of its middle, 15 cm from either side of it.
  const JointVector left = at(0.15);
  const JointVector right = at(-0.15);
  for (int k = 0; k <= 200; ++k) {
    JointVector q{};
    for (std::size_t i = 0; i < kJoints; ++i) q[i] = left[i] + k / 200.0 * (right[i] - left[i]);
    way.push_back(q);
  }
  ASSERT_TRUE(world.IsFree(left, 0.005));
  ASSERT_TRUE(world.IsFree(right, 0.005));
  const auto touch = FirstTouch(world, way, 0.005);
  ASSERT_TRUE(touch.has_value());
  EXPECT_THAT(*touch, HasSubstr("box"));
  world.Place("box", Moved(kIdentityTransform, 0.5, 0, 2));
  EXPECT_FALSE(FirstTouch(world, way, 0.005).has_value());
}

TEST(PoseFollowingTest, RefusesOptionsOutOfRange) {
  FollowOptions options;
  options.velocity_share = 1.5;
  EXPECT_THROW(options.Validate(), InputError);
}

}  // namespace
}  // namespace twin::planning::planning_pose_following_test

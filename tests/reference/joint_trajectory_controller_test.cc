#include "controllers/joint_trajectory.h"

#include <cmath>

#include <gmock/gmock.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"

namespace twin::controllers::joint_trajectory_controller_test {
namespace {

using control::CommandInterface;
using control::ControllerOutput;
using reference::Trajectory;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using namespace std::chrono_literals;

constexpr JointVector kFirst{0, -0.5, 0, -2, 0, 1.5, 0.7};
constexpr JointVector kLast{0.5, -0.4, 0.3, -2.2, -0.3, 1.9, 0};

Trajectory TestTrajectory() {
  return Trajectory({{.q = kFirst}, {.q = kLast}}, {.duration = 2s}, test::PandaLimits());
}

RobotState StateAt(const JointVector& q_d) {
  RobotState state;
  state.q_d = q_d;
  return state;
}

TEST(JointTrajectoryControllerTest, FollowsTheTrajectoryFromTheFirstUpdateOn) {
  const Trajectory trajectory = TestTrajectory();
  JointTrajectoryController controller(trajectory);
  controller.Activate(StateAt(kFirst), Time(3s));
  ControllerOutput output;
  for (Duration t{}; t < 2s; t += 8ms) {
    controller.Update(StateAt(kFirst), Time(3100ms) + t, output);
    EXPECT_EQ(output.target.joint.q, trajectory.Sample(t).q);
    EXPECT_EQ(output.target.joint.dq, trajectory.Sample(t).dq);
    EXPECT_FALSE(output.finished);
  }
}

TEST(JointTrajectoryControllerTest, IsNotDelayedByASkippedUpdate) {
  const Trajectory trajectory = TestTrajectory();
  JointTrajectoryController controller(trajectory);
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(1s), output);
  controller.Update(StateAt(kFirst), Time(1700ms), output);
  EXPECT_EQ(output.target.joint.q, trajectory.Sample(700ms).q);
}

TEST(JointTrajectoryControllerTest, GivesThePoseOfTheRobotsOwnEndEffectorOnThePath) {
  const Trajectory trajectory = TestTrajectory();
  JointTrajectoryController controller(
      trajectory, {.command_interface = CommandInterface::kCartesianPose, .give_velocity = true});
  EXPECT_EQ(controller.command_interface(), CommandInterface::kCartesianPose);
  RobotState state = StateAt(kFirst);
  state.F_T_EE[14] = 0.1034;
  controller.Activate(state, Time(0s));
  ControllerOutput output;
  const model::ArmModel& arm = model::ArmModel::Panda();
  const auto pose = [&](Duration t) {
    return arm.Pose(model::Frame::kEndEffector, trajectory.Sample(t).q, state.F_T_EE);
  };
  controller.Update(state, Time(0s), output);
  for (Duration t = 50ms; t < 1950ms; t += 50ms) {
    controller.Update(state, Time(t), output);
    EXPECT_TRUE(output.has_velocity);
    EXPECT_EQ(output.target.pose.O_T_EE, pose(t));
    for (std::size_t i = 0; i < 3; ++i) {
      const double difference = (pose(t + 1ms)[12 + i] - pose(t - 1ms)[12 + i]) / 2e-3;
      EXPECT_NEAR(output.target.pose.O_dP_EE[i], difference, 1e-5) << i;
    }
  }
}

TEST(JointTrajectoryControllerTest, KeepsGivingTheGoalAtRestOnceFinished) {
  JointTrajectoryController controller(TestTrajectory());
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(0s), output);
  for (const Duration t : std::initializer_list<Duration>{2s, 3s, 1h}) {
    controller.Update(StateAt(kLast), Time(t), output);
    EXPECT_TRUE(output.finished);
    EXPECT_EQ(output.target.joint.q, kLast);
    EXPECT_EQ(output.target.joint.dq, JointVector{});
  }
}

TEST(JointTrajectoryControllerTest, StartsAnewAfterEachActivation) {
  JointTrajectoryController controller(TestTrajectory());
  ControllerOutput output;
  for (const Duration start : std::initializer_list<Duration>{0s, 10s, 20s}) {
    controller.Activate(StateAt(kFirst), Time(start));
    controller.Update(StateAt(kFirst), Time(start), output);
    EXPECT_EQ(output.target.joint.q, kFirst);
    EXPECT_FALSE(output.finished);
    controller.Update(StateAt(kFirst), Time(start + 2s), output);
    EXPECT_TRUE(output.finished);
    controller.Deactivate();
  }
}

TEST(JointTrajectoryControllerTest, RefusesToStartAwayFromTheFirstPoint) {
  JointTrajectoryController controller(TestTrajectory());
  JointVector q_d = kFirst;
  q_d[3] += 0.0009;
  EXPECT_NO_THROW(controller.Activate(StateAt(q_d), Time(0s)));
  q_d[3] = -1.9;
  EXPECT_THAT([&] { controller.Activate(StateAt(q_d), Time(0s)); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("joint 4 of the robot is at -1.900000 rad"),
                                              HasSubstr("starts at -2.000000 rad"),
                                              HasSubstr("differ by 0.001 rad"),
                                              HasSubstr("Move the robot to the first point"))));
  q_d[3] = std::nan("");
  EXPECT_THROW(controller.Activate(StateAt(q_d), Time(0s)), InputError);
}

TEST(JointTrajectoryControllerTest, GivesItsOwnVelocityWhenAskedOrWhenVelocityIsTheCommand) {
  const auto has_velocity = [](const JointTrajectoryOptions& options) {
    JointTrajectoryController controller(TestTrajectory(), options);
    EXPECT_EQ(controller.command_interface(), options.command_interface);
    controller.Activate(StateAt(kFirst), Time(0s));
    ControllerOutput output;
    controller.Update(StateAt(kFirst), Time(0s), output);
    return output.has_velocity;
  };
  EXPECT_FALSE(has_velocity({}));
  EXPECT_TRUE(has_velocity({.give_velocity = true}));
  EXPECT_TRUE(has_velocity({.command_interface = CommandInterface::kJointVelocity}));
}

TEST(JointTrajectoryControllerTest, UpdatesWithoutAllocating) {
  JointTrajectoryController controller(TestTrajectory());
  const RobotState state = StateAt(kFirst);
  controller.Activate(state, Time(0s));
  ControllerOutput output;
  const test::RealtimeGuard guard;
  for (Duration t{}; t < 3s; t += 1ms) controller.Update(state, Time(t), output);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_TRUE(output.finished);
}

}  // namespace
}  // namespace twin::controllers::joint_trajectory_controller_test

#include "twin/run/stepped_robot.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/stepped_fixture.h"
#include "support/bits.h"
#include "twin/core/error.h"

namespace twin::run::run_stepped_robot_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

using Row = std::array<std::uint64_t, StepReport::kSize>;

/// Ten steps of 50 ms along x and up, from the pose of the last reset.
std::vector<Row> Walk(SteppedRobot& robot, double by = 0.01) {
  reference::Target target;
  target.pose.O_T_EE = twin::test::PoseOf(robot.report());
  std::vector<Row> rows;
  for (int i = 0; i < 10; ++i) {
    target.pose.O_T_EE[12] += by;
    target.pose.O_T_EE[14] += by;
    robot.SetTarget(target);
    robot.Advance(50);
    rows.push_back(twin::test::Bits(robot.report()));
  }
  return rows;
}

/// Joint 1 by `by` rad at once.
void Turn(SteppedRobot& robot, double by, int steps) {
  reference::Target target;
  target.joint.q = robot.report().q_d;
  target.joint.q[0] += by;
  for (int i = 0; i < steps; ++i) {
    robot.SetTarget(target);
    robot.Advance(50);
  }
}

TEST(SteppedRobotTest, LeadsTheEndEffectorToATargetWithoutAHeldCycle) {
  SteppedRobot robot(twin::test::Stepped(), twin::test::Files());
  robot.Reset({.seed = 1});
  const Vector3 from = robot.report().position;
  reference::Target target;
  target.pose.O_T_EE = twin::test::PoseOf(robot.report());
  target.pose.O_T_EE[12] += 0.05;
  for (int i = 0; i < 20; ++i) {
    robot.SetTarget(target);
    robot.Advance(50);
    EXPECT_EQ(robot.report().served, 50);
    EXPECT_EQ(robot.report().held, 0);
    EXPECT_GT(robot.report().margin, 0);
  }
  EXPECT_NEAR(robot.report().position[0], from[0] + 0.05, 1e-3);
  EXPECT_NEAR(robot.report().position[1], from[1], 1e-3);
  EXPECT_DOUBLE_EQ(robot.report().time, 1);
  EXPECT_EQ(robot.report().is_moving, 1);
}

TEST(SteppedRobotTest, GivesTheSameBitsAfterEveryResetWithTheSameSeed) {
  SteppedRobot robot(twin::test::Stepped(twin::test::kLossy), twin::test::Files());
  robot.Reset({.seed = 7});
  const std::vector<Row> first = Walk(robot);
  robot.Reset({.seed = 8});
  EXPECT_NE(Walk(robot), first);
  robot.Reset({.seed = 7});
  EXPECT_EQ(Walk(robot), first);
  SteppedRobot another(twin::test::Stepped(twin::test::kLossy), twin::test::Files());
  another.Reset({.seed = 7});
  EXPECT_EQ(Walk(another), first);
}

TEST(SteppedRobotTest, GivesTheSameBitsAfterAnEpisodeThatAReflexEnded) {
  scenario::Scenario scenario = twin::test::Stepped("tick: {generator: none, viability: off}\n");
  scenario.motion.interface = control::CommandInterface::kJointPosition;
  SteppedRobot robot(scenario, twin::test::Files());
  robot.Reset({.seed = 1});
  const auto begin = twin::test::Bits(robot.report());
  Turn(robot, 0.5, 2);
  EXPECT_EQ(robot.report().is_moving, 0);
  EXPECT_NE(robot.report().errors, 0);
  EXPECT_THAT(robot.DescribeErrors(), HasSubstr("joint 1"));
  robot.Reset({.seed = 1});
  EXPECT_EQ(twin::test::Bits(robot.report()), begin);
}

TEST(SteppedRobotTest, TheViabilityFilterKeepsTheSameJumpFromEndingTheMotion) {
  scenario::Scenario scenario = twin::test::Stepped();
  scenario.motion.interface = control::CommandInterface::kJointPosition;
  SteppedRobot robot(scenario, twin::test::Files());
  robot.Reset({.seed = 1});
  const double from = robot.report().q[0];
  Turn(robot, 0.5, 40);
  EXPECT_EQ(robot.report().is_moving, 1);
  EXPECT_EQ(robot.report().errors, 0);
  EXPECT_NEAR(robot.report().q[0], from + 0.5, 1e-3);
}

TEST(SteppedRobotTest, CountsTheCyclesThatALossyLinkLeavesWithoutACommand) {
  SteppedRobot robot(twin::test::Stepped(), twin::test::Files());
  robot.Reset({.seed = 3, .loss = 0.1});
  double held = 0;
  reference::Target target;
  target.pose.O_T_EE = twin::test::PoseOf(robot.report());
  for (int i = 0; i < 40; ++i) {
    robot.SetTarget(target);
    robot.Advance(50);
    EXPECT_EQ(robot.report().served + robot.report().held, 50);
    held += robot.report().held;
  }
  // Either of two messages is lost: 19 % of 2000; three standard deviations are 53.
  EXPECT_NEAR(held, 380, 53);
}

TEST(SteppedRobotTest, AConstantDelayOfACycleEndsNoMotion) {
  SteppedRobot robot(twin::test::Stepped(), twin::test::Files());
  robot.Reset({.seed = 3, .delay = std::chrono::microseconds(300)});
  Walk(robot);
  EXPECT_EQ(robot.report().held, 0);
  EXPECT_EQ(robot.report().is_moving, 1);
}

TEST(SteppedRobotTest, SaysThatNoMotionBeginsWhenTheLinkLosesAll) {
  SteppedRobot robot(twin::test::Stepped(), twin::test::Files());
  EXPECT_THAT([&] { robot.Reset({.seed = 1, .loss = 1}); },
              ThrowsMessage<RobotFault>(HasSubstr("no motion begins")));
}

TEST(SteppedRobotTest, PlacesObjectsAndRefusesAPlaceInsideOfTheTable) {
  SteppedRobot robot(twin::test::Stepped("scene: scenes/table_box.xml\n"), twin::test::Files());
  ASSERT_THAT(robot.objects(), ::testing::ElementsAre("box"));
  Transform X_WB = kIdentityTransform;
  X_WB[12] = 0.45;
  X_WB[13] = -0.1;
  X_WB[14] = 0.325;
  robot.Reset({.seed = 1, .places = {{"box", X_WB}}});
  std::array<double, SteppedRobot::kObjectSize> box{};
  robot.CopyObjects(box);
  EXPECT_NEAR(box[0], 0.45, 1e-4);
  EXPECT_NEAR(box[1], -0.1, 1e-4);
  EXPECT_NEAR(box[2], 0.325, 1e-3);
  EXPECT_NEAR(box[3], 1, 1e-6);
  X_WB[14] = 0.3;
  EXPECT_THAT(
      [&] {
        robot.Reset({.seed = 1, .places = {{"box", X_WB}}});
      },
      ThrowsMessage<InputError>(HasSubstr("inside of table")));
}

TEST(SteppedRobotTest, AHeavierLoadBendsTheArmAndGoesWhenGivenAnew) {
  scenario::Scenario scenario = twin::test::Stepped();
  scenario.robot.load.m_load = 0.001;
  SteppedRobot robot(scenario, twin::test::Files());
  const auto height = [&](double mass) {
    robot.Reset({.seed = 1, .masses = {{"load", mass}}});
    for (int i = 0; i < 10; ++i) robot.Advance(50);
    return robot.report().position[2];
  };
  const double light = height(0.001);
  EXPECT_LT(height(2), light - 1e-3);
  EXPECT_NEAR(height(0.001), light, 1e-9);
}

TEST(SteppedRobotTest, ReportsTheForceWithWhichItPressesOnATable) {
  scenario::Scenario scenario = twin::test::Stepped(
      "scene: scenes/table_box.xml\n"
      "onboard: {collision_behavior: off, K_x: {translation: 600 N/m, rotation: 30 Nm/rad}}\n");
  scenario.motion.controller = ControllerMode::kCartesianImpedance;
  scenario.robot.q_start = JointVector{0, -0.13681, 0, -2.23480, 0, 2.09800, -0.78540};
  Transform aside = kIdentityTransform;
  aside[12] = 0.5;
  aside[13] = 0.25;
  aside[14] = 0.325;
  SteppedRobot robot(scenario, twin::test::Files());
  robot.Reset({.seed = 1, .places = {{"box", aside}}});
  reference::Target target;
  target.pose.O_T_EE = twin::test::PoseOf(robot.report());
  for (int i = 0; i < 300; ++i) {
    if (robot.report().contact[2] > -5) target.pose.O_T_EE[14] -= 0.0005;
    robot.SetTarget(target);
    robot.Advance(50);
  }
  EXPECT_EQ(robot.report().is_moving, 1) << robot.DescribeErrors();
  EXPECT_LT(robot.report().contact[2], -4);
  EXPECT_NEAR(robot.report().wrench[2], robot.report().contact[2], 1);
}

TEST(SteppedRobotTest, KeepsTheStateItHasComeToAsTheStart) {
  SteppedRobot robot(twin::test::Stepped(), twin::test::Files());
  robot.Reset({.seed = 1});
  const double before = robot.report().position[0];
  Walk(robot);
  robot.KeepAsStart();
  robot.Reset({.seed = 1});
  const auto first = twin::test::Bits(robot.report());
  EXPECT_GT(robot.report().position[0], before + 0.09);
  Walk(robot);
  robot.Reset({.seed = 1});
  EXPECT_EQ(twin::test::Bits(robot.report()), first);
}

TEST(SteppedRobotTest, RefusesATargetThatIsNotFinite) {
  SteppedRobot robot(twin::test::Stepped(), twin::test::Files());
  reference::Target target;
  target.pose.O_T_EE[12] = std::nan("");
  EXPECT_THAT([&] { robot.SetTarget(target); },
              ThrowsMessage<InputError>(HasSubstr("it must be finite")));
}

TEST(SteppedRobotTest, FieldsNameEveryNumberOfAReport) {
  StepReport report;
  report.is_moving = 5;
  report.width = 3;
  std::array<double, StepReport::kSize> row{};
  std::memcpy(row.data(), &report, sizeof report);
  for (const StepReport::Field& field : StepReport::Fields()) {
    const double expected = field.name == "is_moving" ? 5 : field.name == "width" ? 3 : 0;
    EXPECT_EQ(row[field.begin], expected) << field.name;
  }
}

}  // namespace
}  // namespace twin::run::run_stepped_robot_test

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/run/result.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_max_deviation_test {
namespace {

using Interface = control::CommandInterface;
constexpr auto kJointImpedance = ControllerMode::kJointImpedance;
constexpr auto kCartesianImpedance = ControllerMode::kCartesianImpedance;
constexpr double kOff = std::numeric_limits<double>::infinity();

TEST(MaxDeviationTest, OfAStiffRobotItIs20mradOr20mm) {
  const Scenario scenario;
  for (const Interface interface : {Interface::kJointPosition, Interface::kJointVelocity}) {
    const run::DeviationLimit limit = run::LimitOf(scenario, interface, kJointImpedance);
    EXPECT_EQ(limit.joints, 0.02);
    EXPECT_EQ(limit.position, kOff);
    EXPECT_EQ(limit.angle, kOff);
  }
  const run::DeviationLimit limit =
      run::LimitOf(scenario, Interface::kCartesianPose, kCartesianImpedance);
  EXPECT_EQ(limit.joints, kOff);
  EXPECT_EQ(limit.position, 0.02);
  EXPECT_EQ(limit.angle, 0.02);
}

TEST(MaxDeviationTest, ItGrowsAsTheRobotIsSofter) {
  Scenario scenario;
  scenario.onboard.K_theta[6] = 500;  // as delivered: 2000
  scenario.onboard.K_x = {1500, 3000, 3000, 300, 300, 300};
  EXPECT_EQ(run::LimitOf(scenario, Interface::kJointPosition, kJointImpedance).joints, 4 * 0.02);
  EXPECT_EQ(run::LimitOf(scenario, Interface::kCartesianPose, kCartesianImpedance).position,
            2 * 0.02);
  scenario.onboard.K_theta.fill(14250);
  EXPECT_EQ(run::LimitOf(scenario, Interface::kJointPosition, kJointImpedance).joints, 0.02);
  scenario.onboard.K_theta[0] = 0;
  EXPECT_EQ(run::LimitOf(scenario, Interface::kJointPosition, kJointImpedance).joints, kOff);
}

TEST(MaxDeviationTest, TorquesAndPushesAreJudgedOnlyWhenItIsSaid) {
  Scenario scenario;
  EXPECT_EQ(run::LimitOf(scenario, Interface::kTorque, kJointImpedance).joints, kOff);
  scenario.perturbations.emplace_back(plant::Push{});
  EXPECT_EQ(run::LimitOf(scenario, Interface::kJointPosition, kJointImpedance).joints, kOff);
  scenario.max_deviation.joints = 0.1;
  EXPECT_EQ(run::LimitOf(scenario, Interface::kTorque, kJointImpedance).joints, 0.1);
  EXPECT_EQ(run::LimitOf(scenario, Interface::kJointPosition, kJointImpedance).joints, 0.1);
}

TEST(MaxDeviationTest, WhatIsSaidIsReadAndWrittenAgain) {
  for (const std::string said : {"off", "{joints: 0.03 rad}", "{joints: off}"}) {
    const std::string text = test::FullText() + "max_deviation: " + said + "\n";
    const Scenario scenario = Parse(text, "s.yaml");
    EXPECT_EQ(scenario.max_deviation.joints, said == "{joints: 0.03 rad}" ? 0.03 : kOff);
    EXPECT_NE(ToYaml(scenario).find("max_deviation: " + said + "\n"), std::string::npos);
    EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml"), scenario);
  }
  EXPECT_EQ(ToYaml(Parse(test::FullText(), "s.yaml")).find("max_deviation"), std::string::npos);
}

TEST(MaxDeviationTest, OnlyAMotionThatEndedWellIsJudged) {
  run::FollowedMotion motion;
  motion.deviation.joints =
      loop::Deviation::Joints{.largest = 0.03, .joint = 0, .at = {}, .rms = 0};
  motion.limit.joints = 0.02;
  EXPECT_FALSE(motion.exceeds());
  motion.succeeded = true;
  EXPECT_TRUE(motion.exceeds());
  EXPECT_EQ(motion.Excess(), "30 mrad (joint 1, at 0.000 s), above the limit of 20 mrad");
  motion.limit.joints = 0.03;
  EXPECT_FALSE(motion.exceeds());
  motion.deviation.joints->largest = kOff;  // a state that was not finite
  EXPECT_TRUE(motion.exceeds());
}

}  // namespace
}  // namespace twin::scenario::scenario_max_deviation_test

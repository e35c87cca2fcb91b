// Things in the hand: the plant, the hand's controller and the arm together.

#include <algorithm>

#include <gtest/gtest.h>

#include "robot/grasp_rig.h"

namespace twin::robot::robot_grasp_test {
namespace {

using test::GraspRig;

constexpr double kPadFriction = 1;  // of a pad on whatever it touches, as the model has it

constexpr hand::Grasp kGrasp{.width = 0.05, .speed = 0.1, .force = 20};

/// How far an object has slipped and turned in the hand.
struct Slip {
  double distance_mm = 0;
  double angle_deg = 0;
};

/// Shakes what is held: a second for it to settle, then ten. @returns the largest slip of the ten.
Slip SlipWhenShaken(GraspRig& rig, const std::string& body) {
  Eigen::Isometry3d settled;
  Slip slip;
  int not_grasped = 0;
  rig.Shake(12'000, [&](int k) {
    if (k == 2000) settled = rig.InHand(body);
    not_grasped += rig.hand().state().is_grasped ? 0 : 1;
    if (k < 2000) return;
    const Eigen::Isometry3d moved = settled.inverse() * rig.InHand(body);
    slip.distance_mm = std::max(slip.distance_mm, 1e3 * moved.translation().norm());
    slip.angle_deg =
        std::max(slip.angle_deg, 180 / M_PI * Eigen::AngleAxisd(moved.linear()).angle());
  });
  EXPECT_EQ(not_grasped, 0);
  return slip;
}

struct Object {
  std::string scene;
  std::string body;
};

class RobotGraspTest : public testing::TestWithParam<Object> {};

TEST_P(RobotGraspTest, HoldsWhatIsShaken) {
  GraspRig rig(GetParam().scene);
  ASSERT_NO_FATAL_FAILURE(rig.PickUp(kGrasp));
  EXPECT_NEAR(rig.hand().state().width, 0.05, 2e-4);
  EXPECT_NEAR(rig.BodyPose(GetParam().body).translation().z(), 0.475, 0.02);
  const Slip slip = SlipWhenShaken(rig, GetParam().body);
  RecordProperty("slip_mm", std::to_string(slip.distance_mm));
  RecordProperty("slip_deg", std::to_string(slip.angle_deg));
  EXPECT_LT(slip.distance_mm, 0.1);
  EXPECT_LT(slip.angle_deg, 1);
}

/// A pull on the object along base y, tangential to the pads, for a second from now.
void Pull(GraspRig& rig, const std::string& body, double force) {
  rig.plant().Perturb(plant::Push{.body = body,
                                  .begin = rig.plant().plant_time(),
                                  .duration = std::chrono::seconds(1),
                                  .rise = std::chrono::milliseconds(200),
                                  .force = {0, force, 0}});
  rig.Wait(1500);
}

TEST_P(RobotGraspTest, LosesWhatIsPulledHarderThanFrictionHolds) {
  GraspRig rig(GetParam().scene);
  ASSERT_NO_FATAL_FAILURE(rig.PickUp(kGrasp));
  const double friction = 2 * kPadFriction * kGrasp.force;
  Pull(rig, GetParam().body, friction + 15);
  EXPECT_FALSE(rig.hand().state().is_grasped);
  EXPECT_GT(rig.InHand(GetParam().body).translation().norm(), 0.15);
  EXPECT_LT(rig.hand().state().width, 1e-3);
}

TEST_P(RobotGraspTest, HoldsWhatIsPulledLessThanFrictionHolds) {
  GraspRig rig(GetParam().scene);
  ASSERT_NO_FATAL_FAILURE(rig.PickUp(kGrasp));
  const Eigen::Isometry3d before = rig.InHand(GetParam().body);
  const double friction = 2 * kPadFriction * kGrasp.force;
  Pull(rig, GetParam().body, friction - 10);
  EXPECT_TRUE(rig.hand().state().is_grasped);
  EXPECT_LT((rig.InHand(GetParam().body).translation() - before.translation()).norm(), 1e-3);
}

TEST_P(RobotGraspTest, StopLetsGo) {
  GraspRig rig(GetParam().scene);
  ASSERT_NO_FATAL_FAILURE(rig.PickUp(kGrasp));
  EXPECT_EQ(rig.Run(hand::Stop{}), HandResult::kSuccess);
  rig.Wait(1000);
  EXPECT_FALSE(rig.hand().state().is_grasped);
  EXPECT_LT(rig.BodyPose(GetParam().body).translation().z(), 0.33);
}

INSTANTIATE_TEST_SUITE_P(Objects, RobotGraspTest,
                         testing::Values(Object{"table_box.xml", "box"},
                                         Object{"table_ball.xml", "ball"}),
                         [](const auto& object) { return object.param.body; });

}  // namespace
}  // namespace twin::robot::robot_grasp_test

#include "twin/teleop/mapping.h"

#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include "twin/model/transform.h"

namespace twin::teleop::teleop_mapping_test {
namespace {

constexpr Mapping::Speeds kFull{
    .along = 0.2, .about = 0.5, .ahead = 0.6, .turning = 0.8, .joint = 0.5};

/// A mapping that somebody leads, and the sample that leads it.
class MappingTest : public testing::Test {
 protected:
  MappingTest() {
    mapping.Begin(true);
    situation.connected = true;
    static_cast<void>(Look());  // counters, and a centred stick
  }
  Wish Look() {
    ++sample.sequence;
    return mapping.Update(sample, situation);
  }
  Wish Push(std::size_t axis, double x) {
    sample.axes = {};
    sample.axes[axis] = x;
    return Look();
  }
  void Handle(const Vector6& at) {
    sample.kind = AxisKind::kPose;
    sample.axes = at;
  }

  Mapping mapping{MappingConfig{}, kFull};
  Situation situation;
  OperatorSample sample;
};

TEST_F(MappingTest, MeansFullSpeedByFullDeflection) {
  EXPECT_DOUBLE_EQ(Push(1, -1).twist[1], -kFull.along);
}

TEST_F(MappingTest, MeansNothingInsideTheDeadZone) {
  EXPECT_EQ(Push(0, 0.049), Wish());
}

TEST_F(MappingTest, BeginsWithoutAStepAtTheEndOfTheDeadZone) {
  EXPECT_NEAR(Push(0, 0.05 + 0.95 * 0.01).twist[0], 0.01 * kFull.along, 1e-12);
}

TEST_F(MappingTest, MeansNothingByAxesThatAreNotFinite) {
  EXPECT_EQ(Push(0, std::numeric_limits<double>::quiet_NaN()), Wish());
}

TEST_F(MappingTest, IsSlowerWhenFine) {
  ++sample.scale_presses;
  EXPECT_DOUBLE_EQ(Push(0, 1).twist[0], MappingConfig().fine * kFull.along);
}

TEST_F(MappingTest, LeadsAlongTheToolsAxesInItsFrame) {
  situation.O_T_EE_d = model::Turned(kIdentityTransform, Eigen::Vector3d(0, 0, 1.5707963267948966),
                                     Eigen::Vector3d::Zero());
  ++sample.frame_presses;
  static_cast<void>(Push(0, 0));
  const Wish wish = Push(0, 1);
  EXPECT_NEAR(wish.twist[0], 0, 1e-12);
  EXPECT_NEAR(wish.twist[1], kFull.along, 1e-12);
}

TEST_F(MappingTest, DrivesTheBaseAfterAModePress) {
  ++sample.mode_presses;
  static_cast<void>(Push(0, 0));
  const Wish wish = Push(0, 1);
  EXPECT_DOUBLE_EQ(wish.base.v, kFull.ahead);
  EXPECT_EQ(wish.twist, Vector6{});
}

TEST_F(MappingTest, TurnsAJointByTheFirstAxis) {
  sample.joint = 3;
  static_cast<void>(Push(0, 0));
  const Wish wish = Push(0, -1);
  EXPECT_EQ(wish.joint, 3);
  EXPECT_DOUBLE_EQ(wish.turn, -kFull.joint);
  EXPECT_EQ(wish.twist, Vector6{});
}

TEST_F(MappingTest, WaitsForTheArmToRestBeforeAnotherJointTurns) {
  sample.joint = 3;
  static_cast<void>(Push(0, 0));
  situation.arm_rests = false;
  sample.joint = 5;
  EXPECT_EQ(Push(0, 1), (Wish{.joint = 3}));
  situation.arm_rests = true;
  EXPECT_EQ(Push(0, 1), (Wish{.joint = 5, .turn = kFull.joint}));
}

TEST_F(MappingTest, WaitsForACentredStickBetweenHandAndJoints) {
  sample.joint = 3;
  EXPECT_EQ(Push(0, 1), (Wish{.joint = 3}));
  static_cast<void>(Push(0, 0));
  EXPECT_DOUBLE_EQ(Push(0, 1).turn, kFull.joint);
  sample.joint = 0;
  EXPECT_EQ(Push(0, 1), Wish());
}

TEST_F(MappingTest, IgnoresAJointThatTheArmDoesNotHave) {
  sample.joint = 8;
  EXPECT_DOUBLE_EQ(Push(0, 1).twist[0], kFull.along);
}

TEST_F(MappingTest, TurnsTheBaseLeftByAPushToTheLeft) {
  ++sample.mode_presses;
  static_cast<void>(Push(0, 0));
  EXPECT_DOUBLE_EQ(Push(1, 1).base.w, kFull.turning);
}

TEST_F(MappingTest, WaitsForTheArmToRestBeforeTheBaseIsLed) {
  ++sample.mode_presses;
  situation.arm_rests = false;
  static_cast<void>(Push(0, 0));
  EXPECT_EQ(mapping.mode(), Mode::kArm);
  EXPECT_TRUE(mapping.is_switching());
  EXPECT_EQ(Push(0, 1), Wish());
}

TEST_F(MappingTest, WaitsForACentredStickAfterASwitch) {
  static_cast<void>(Push(0, 1));
  ++sample.mode_presses;
  static_cast<void>(Push(0, 1));
  EXPECT_EQ(Push(0, 1), Wish());
  EXPECT_TRUE(mapping.awaits_release());
  static_cast<void>(Push(0, 0));
  EXPECT_FALSE(mapping.awaits_release());
  EXPECT_GT(Push(0, 1).base.v, 0);
}

TEST_F(MappingTest, AwaitsNoReleaseOfWhatNothingHears) {
  situation.connected = false;
  EXPECT_EQ(Push(0, 1), Wish());
  EXPECT_FALSE(mapping.awaits_release());
  situation.connected = true;
  EXPECT_EQ(Push(0, 1), Wish());
  EXPECT_TRUE(mapping.awaits_release());
}

TEST_F(MappingTest, LosesNoPressWithALostSample) {
  sample.gripper_presses += 3;
  sample.mode_presses += 2;
  static_cast<void>(Look());
  EXPECT_EQ(mapping.gripper_presses(), 3U);
  EXPECT_EQ(mapping.mode(), Mode::kArm);
}

TEST_F(MappingTest, CountsThePressesOfItsFirstSample) {
  Mapping late(MappingConfig{}, kFull);
  late.Begin(true);
  sample.gripper_presses = 5;
  static_cast<void>(late.Update(sample, situation));
  EXPECT_EQ(late.gripper_presses(), 5U);
}

TEST_F(MappingTest, TakesACounterThatWentBackAsAnotherDevices) {
  sample.gripper_presses = 5;
  static_cast<void>(Look());
  sample.gripper_presses = 0;
  static_cast<void>(Look());
  EXPECT_EQ(mapping.gripper_presses(), 5U);
}

TEST_F(MappingTest, KnowsNoBaseWhereThereIsNone) {
  mapping.Begin(false);
  static_cast<void>(Look());
  ++sample.mode_presses;
  static_cast<void>(Look());
  EXPECT_EQ(mapping.mode(), Mode::kArm);
}

TEST_F(MappingTest, MovesNothingWhileItIsStopped) {
  ++sample.stop_presses;
  EXPECT_EQ(Push(0, 1), Wish());
  EXPECT_TRUE(mapping.stopped());
}

TEST_F(MappingTest, StaysStoppedWhenStopAndReleaseComeTogether) {
  ++sample.stop_presses;
  ++sample.release_presses;
  static_cast<void>(Look());
  EXPECT_TRUE(mapping.stopped());
}

TEST_F(MappingTest, GoesOnAfterAReleaseAndACentredStick) {
  ++sample.stop_presses;
  static_cast<void>(Push(0, 1));
  ++sample.release_presses;
  EXPECT_EQ(Push(0, 1), Wish());
  static_cast<void>(Push(0, 0));
  EXPECT_GT(Push(0, 1).twist[0], 0);
}

TEST_F(MappingTest, FollowsAHandleFromWhereItIsEngaged) {
  Handle({0.3, 0.1, 0, 0, 0, 0});
  EXPECT_EQ(Look().pose, situation.O_T_EE_d);
  sample.axes[0] += 0.02;
  EXPECT_NEAR((*Look().pose)[12], 0.02, 1e-12);
}

TEST_F(MappingTest, TurnsAsTheHandleTurns) {
  Handle({0, 0, 0, 0, 0, 0.4});
  static_cast<void>(Look());
  sample.axes[5] = 0.7;
  const Eigen::Vector3d turn = model::TurnBetween(situation.O_T_EE_d, *Look().pose);
  EXPECT_LT((turn - Eigen::Vector3d(0, 0, 0.3)).norm(), 1e-12);
}

TEST_F(MappingTest, RecentresAHandleWithoutAnyMotion) {
  Handle({0.1, 0, 0, 0, 0, 0});
  static_cast<void>(Look());
  sample.engaged = false;
  sample.axes[0] = -0.1;
  EXPECT_EQ(Look(), Wish());
  sample.engaged = true;
  EXPECT_EQ(Look().pose, situation.O_T_EE_d);
}

TEST_F(MappingTest, RecentresAStickWithoutAnyMotion) {
  sample.engaged = false;
  EXPECT_EQ(Push(0, 1), Wish());
  sample.engaged = true;
  EXPECT_EQ(Push(0, 1), Wish());
}

TEST_F(MappingTest, DoesNotMoveAHandlesArmByASwitchOfScale) {
  Handle({0, 0, 0, 0, 0, 0});
  static_cast<void>(Look());
  sample.axes[0] = 0.1;
  situation.O_T_EE_d = *Look().pose;
  ++sample.scale_presses;
  EXPECT_EQ(Look().pose, situation.O_T_EE_d);
}

}  // namespace
}  // namespace twin::teleop::teleop_mapping_test

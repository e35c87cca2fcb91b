#include "twin/loop/deviation.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "support/realtime_guard.h"
#include "twin/model/transform.h"

namespace twin::loop::loop_deviation_test {
namespace {

constexpr std::size_t kJoint = 2;

Time At(std::uint64_t k) {
  return Time(kCycle * static_cast<std::int64_t>(k));
}

RobotState StateOf(std::uint64_t id, double q) {
  RobotState state;
  state.message_id = id;
  state.q = {0, -0.8, 0, -2.4, 0, 1.6, 0.8};
  state.q[kJoint] = q;
  return state;
}

reference::Target TargetOf(double q) {
  reference::Target target;
  target.joint.q = StateOf(0, q).q;
  return target;
}

double Wave(std::uint64_t k) {
  return 0.4 * std::sin(3 * static_cast<double>(k) * kCycleSeconds);
}

TEST(DeviationMeterTest, FindsHowFarTheArmIsOffItsTarget) {
  DeviationMeter meter(control::CommandInterface::kJointPosition);
  constexpr std::uint64_t kCycles = 1047;  // the whole half-wave: 0.4 rad at t = pi / 6
  double squares = 0;
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 1; k <= kCycles; ++k) {
    meter.Aim(k, TargetOf(Wave(k)));
    meter.Measure(StateOf(k + 1, 0.7 * Wave(k)), At(k + 1));
    squares += std::pow(0.3 * Wave(k), 2);
  }
  const bool untouched = guard.counts() == test::RealtimeGuard::Counts{};
  EXPECT_TRUE(untouched);
  const auto joints = meter.Result().joints;
  ASSERT_TRUE(joints);
  EXPECT_NEAR(joints->largest, 0.3 * 0.4, 1e-6);
  EXPECT_EQ(joints->joint, kJoint);
  EXPECT_EQ(joints->at, At(525));
  EXPECT_NEAR(joints->rms, std::sqrt(squares / kCycles), 1e-12);
  EXPECT_FALSE(meter.Result().pose);
}

TEST(DeviationMeterTest, AStateCountsOnlyAfterTheOneThatWasAnswered) {
  DeviationMeter meter(control::CommandInterface::kJointVelocity);
  meter.Measure(StateOf(1, 0.5), At(1));  // nothing was answered yet
  meter.Aim(5, TargetOf(0));
  meter.Measure(StateOf(5, 0.5), At(5));
  meter.Measure(StateOf(7, 0.5), At(7));  // state 6 was lost
  EXPECT_FALSE(meter.Result().joints);
  meter.Measure(StateOf(6, 0.25), At(6));
  EXPECT_EQ(meter.Result().joints->largest, 0.25);
}

TEST(DeviationMeterTest, ATargetWithoutJointsMeasuresNothing) {
  DeviationMeter meter(control::CommandInterface::kTorque);
  meter.Aim(1, {});
  meter.Measure(StateOf(2, 0.5), At(2));
  EXPECT_FALSE(meter.Result().joints);
}

TEST(DeviationMeterTest, WhatIsNoNumberIsInfinitelyFar) {
  DeviationMeter meter(control::CommandInterface::kJointPosition);
  for (std::uint64_t k = 1; k <= 3; ++k) {
    meter.Aim(k, TargetOf(0));
    meter.Measure(StateOf(k + 1, k == 2 ? std::nan("") : 0.1), At(k + 1));
  }
  EXPECT_EQ(meter.Result().joints->largest, std::numeric_limits<double>::infinity());
  EXPECT_EQ(meter.Result().joints->at, At(3));
}

TEST(DeviationMeterTest, PosesAreOffByDistanceAndTurn) {
  DeviationMeter meter(control::CommandInterface::kCartesianPose);
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(2.5, Eigen::Vector3d(0, 0.6, 0.8)));
  reference::Target target;
  target.pose.O_T_EE = model::Pose(Eigen::Quaterniond::Identity(), {0.3, 0, 0.5});
  RobotState state;
  state.message_id = 2;
  state.O_T_EE = model::Pose(turned, {0.3, 0.03, 0.54});
  const test::RealtimeGuard guard;
  meter.Aim(1, target);
  meter.Measure(state, At(2));
  const bool untouched = guard.counts() == test::RealtimeGuard::Counts{};
  EXPECT_TRUE(untouched);
  const auto pose = meter.Result().pose;
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->position, 0.05, 1e-12);
  EXPECT_NEAR(pose->angle, 2.5, 1e-12);
  EXPECT_EQ(pose->angle_at, At(2));
}

}  // namespace
}  // namespace twin::loop::loop_deviation_test

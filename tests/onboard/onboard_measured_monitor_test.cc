#include "twin/onboard/measured_monitor.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>

#include "support/panda_limits.h"

namespace twin::onboard::onboard_measured_monitor_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

MeasuredBounds Bounds() {
  MeasuredBounds bounds;
  bounds.q_margin_rad = 0.02;
  bounds.velocity_margin = 0.1;
  bounds.translation_max_m_per_s = 2;
  bounds.power_max_W = 300;
  bounds.clearance_m = 0.015;
  return bounds;
}

/// In the middle of everything.
MeasuredMonitor::Measured Harmless() {
  MeasuredMonitor::Measured measured;
  const JointLimits limits = test::PandaLimits();
  for (std::size_t i = 0; i < kJoints; ++i) {
    measured.sensors.q[i] = 0.5 * (limits.q_min[i] + limits.q_max[i]);
  }
  measured.self_distance = 0.2;
  return measured;
}

class MeasuredMonitorTest : public ::testing::Test {
 protected:
  std::vector<RobotError> ErrorsOf(const MeasuredMonitor::Measured& measured,
                                   const JointVector& tau_J_d = {}, bool is_cartesian = true) {
    found_ = monitor_.Check(measured, tau_J_d, is_cartesian, 42);
    std::vector<RobotError> errors;
    for (const Violation& violation : found_.items()) {
      EXPECT_EQ(violation.message_id, 42u);
      errors.push_back(violation.error);
    }
    return errors;
  }
  const Violation& First() const { return found_.items().front(); }

  JointLimits limits_ = test::PandaLimits();
  MeasuredMonitor monitor_{limits_, test::PandaCartesianLimits(), Bounds()};
  Violations found_;
};

TEST_F(MeasuredMonitorTest, FindsNothingWhereThereIsNothing) {
  EXPECT_THAT(ErrorsOf(Harmless()), IsEmpty());
  EXPECT_FALSE(monitor_.IsOutOfRange(Harmless().sensors.q));
}

TEST_F(MeasuredMonitorTest, APositionMayGoBeyondItsLimitByTheMargin) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const bool is_upper : {false, true}) {
      const double bound = is_upper ? limits_.q_max[i] + 0.02 : limits_.q_min[i] - 0.02;
      MeasuredMonitor::Measured measured = Harmless();
      measured.sensors.q[i] = bound;
      EXPECT_THAT(ErrorsOf(measured), IsEmpty()) << "joint " << i + 1;
      EXPECT_FALSE(monitor_.IsOutOfRange(measured.sensors.q));
      measured.sensors.q[i] = bound + (is_upper ? 1e-7 : -1e-7);
      EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kJointPositionLimitsViolation));
      EXPECT_EQ(First().axis, static_cast<int>(i));
      EXPECT_EQ(First().value, measured.sensors.q[i]);
      EXPECT_DOUBLE_EQ(First().limit, bound);
      EXPECT_TRUE(monitor_.IsOutOfRange(measured.sensors.q));
    }
  }
}

TEST_F(MeasuredMonitorTest, AVelocityMayBeAboveItsLimitByTheMargin) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      MeasuredMonitor::Measured measured = Harmless();
      measured.sensors.dq[i] = sign * 1.1 * limits_.dq_max[i];
      EXPECT_THAT(ErrorsOf(measured), IsEmpty()) << "joint " << i + 1;
      measured.sensors.dq[i] *= 1 + 1e-6;
      EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kJointVelocityViolation));
      EXPECT_EQ(First().axis, static_cast<int>(i));
      EXPECT_EQ(First().value, measured.sensors.dq[i]);
      EXPECT_DOUBLE_EQ(First().limit, sign * 1.1 * limits_.dq_max[i]);
    }
  }
}

TEST_F(MeasuredMonitorTest, TheTorqueSensorsRangeIsTwentyPercentAboveTheDrives) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      MeasuredMonitor::Measured measured = Harmless();
      measured.sensors.tau_J[i] = sign * 1.2 * limits_.tau_max[i];
      EXPECT_THAT(ErrorsOf(measured), IsEmpty());
      measured.sensors.tau_J[i] += sign * 1e-4;
      EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kTauJRangeViolation));
      EXPECT_EQ(First().axis, static_cast<int>(i));
      EXPECT_EQ(First().value, measured.sensors.tau_J[i]);
      EXPECT_DOUBLE_EQ(First().limit, sign * 1.2 * limits_.tau_max[i]);
    }
  }
}

TEST_F(MeasuredMonitorTest, TheTorqueSensorsRangeCanBeSet) {
  MeasuredBounds bounds = Bounds();
  bounds.tau_J_range = JointVector{30, 31, 32, 33, 34, 35, 36};
  monitor_ = MeasuredMonitor(limits_, test::PandaCartesianLimits(), bounds);
  MeasuredMonitor::Measured measured = Harmless();
  measured.sensors.tau_J[6] = 36;
  EXPECT_THAT(ErrorsOf(measured), IsEmpty());
  measured.sensors.tau_J = {0, 0, 0, -33.1, 0, 0, 36.1};
  EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kTauJRangeViolation));
  EXPECT_EQ(First().axis, 3);
  EXPECT_EQ(First().limit, -33);
}

TEST_F(MeasuredMonitorTest, TheEndEffectorsSpeedIsTheLengthOfItsVelocity) {
  for (const bool is_cartesian : {false, true}) {
    MeasuredMonitor::Measured measured = Harmless();
    measured.O_dP_EE = {-1.2, 1.6 * 0.6, 1.6 * 0.8, 0, 0, 0};
    EXPECT_THAT(ErrorsOf(measured, {}, is_cartesian), IsEmpty());
    measured.O_dP_EE[0] = -1.201;
    EXPECT_THAT(ErrorsOf(measured, {}, is_cartesian),
                ElementsAre(RobotError::kCartesianVelocityViolation));
    EXPECT_EQ(First().axis, 0);
    EXPECT_NEAR(First().value, std::hypot(1.201, 1.6), 1e-12);
    EXPECT_EQ(First().limit, 2);
  }
}

TEST_F(MeasuredMonitorTest, TheEndEffectorsTurningCountsInCartesianMotionsAlone) {
  MeasuredMonitor::Measured measured = Harmless();
  measured.O_dP_EE = {0, 0, 0, 2.75 * 0.48, -2.75 * 0.6, 2.75 * 0.64};
  EXPECT_THAT(ErrorsOf(measured), IsEmpty());
  measured.O_dP_EE[3] += 1e-6;
  EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kCartesianVelocityViolation));
  EXPECT_EQ(First().axis, 1);
  EXPECT_GT(First().value, 2.75);
  EXPECT_DOUBLE_EQ(First().limit, 2.75);
  measured.O_dP_EE[3] = 10;
  EXPECT_THAT(ErrorsOf(measured, {}, false), IsEmpty());
}

TEST_F(MeasuredMonitorTest, PowerIsThatOfTorqueAndGravityTogether) {
  MeasuredMonitor::Measured measured = Harmless();
  measured.sensors.dq = {2, -1, 0, 0.5, 0, 0, 0};
  measured.g = {0, -30, 0, 20, 0, 0, 5};
  // 2 * 80 + 1 * (40 + 30) + 0.5 * (120 + 20) = 300
  const JointVector tau_J_d{80, -40, 99, 120, 0, 0, 0};
  EXPECT_THAT(ErrorsOf(measured, tau_J_d), IsEmpty());
  JointVector more = tau_J_d;
  more[0] += 0.001;
  EXPECT_THAT(ErrorsOf(measured, more), ElementsAre(RobotError::kPowerLimitViolation));
  EXPECT_EQ(First().axis, -1);
  EXPECT_NEAR(First().value, 300.002, 1e-9);
  EXPECT_EQ(First().limit, 300);
}

TEST_F(MeasuredMonitorTest, BrakingTakesNoPower) {
  MeasuredMonitor::Measured measured = Harmless();
  measured.sensors.dq = {2, 2, 2, 2, 2, 2, 2};
  EXPECT_THAT(ErrorsOf(measured, {-87, -87, -87, -87, -12, -12, -12}), IsEmpty());
  EXPECT_THAT(ErrorsOf(measured, {87, 87, 87, 87, 12, 12, 12}),
              ElementsAre(RobotError::kPowerLimitViolation));
}

TEST_F(MeasuredMonitorTest, PartsOfTheArmKeepTheirDistance) {
  MeasuredMonitor::Measured measured = Harmless();
  measured.self_distance = 0.015;
  EXPECT_THAT(ErrorsOf(measured), IsEmpty());
  measured.self_distance = 0.0149;
  EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kSelfCollisionAvoidanceViolation));
  EXPECT_EQ(First().axis, -1);
  EXPECT_EQ(First().value, 0.0149);
  EXPECT_EQ(First().limit, 0.015);
}

TEST_F(MeasuredMonitorTest, ReportsEachErrorOnceWithTheFirstJoint) {
  MeasuredMonitor::Measured measured = Harmless();
  measured.sensors.q[2] = 4;
  measured.sensors.q[5] = 5;
  measured.sensors.dq[1] = -5;
  measured.sensors.dq[6] = 5;
  measured.sensors.tau_J[4] = 100;
  measured.sensors.tau_J[5] = 100;
  measured.O_dP_EE = {9, 9, 9, 9, 9, 9};
  measured.self_distance = -0.1;
  EXPECT_THAT(
      ErrorsOf(measured, {0, -87, 0, 0, 0, 0, 12}),
      ElementsAre(RobotError::kJointPositionLimitsViolation, RobotError::kJointVelocityViolation,
                  RobotError::kTauJRangeViolation, RobotError::kCartesianVelocityViolation,
                  RobotError::kPowerLimitViolation, RobotError::kSelfCollisionAvoidanceViolation));
  EXPECT_EQ(found_.items()[0].axis, 2);
  EXPECT_EQ(found_.items()[1].axis, 1);
  EXPECT_EQ(found_.items()[2].axis, 4);
  EXPECT_EQ(found_.items()[3].axis, 0);
}

TEST_F(MeasuredMonitorTest, WhatIsNoNumberIsBeyondItsLimit) {
  MeasuredMonitor::Measured measured = Harmless();
  measured.sensors.q[3] = kNaN;
  EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kJointPositionLimitsViolation));
  EXPECT_TRUE(monitor_.IsOutOfRange(measured.sensors.q));
  measured = Harmless();
  measured.sensors.tau_J[3] = kNaN;
  EXPECT_THAT(ErrorsOf(measured), ElementsAre(RobotError::kTauJRangeViolation));
  measured = Harmless();
  EXPECT_THAT(ErrorsOf(measured, {0, 0, kNaN, 0, 0, 0, 0}),
              ElementsAre(RobotError::kPowerLimitViolation));
}

}  // namespace
}  // namespace twin::onboard::onboard_measured_monitor_test

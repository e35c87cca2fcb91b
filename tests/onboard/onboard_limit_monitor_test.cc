#include "twin/onboard/limit_monitor.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/panda_limits.h"

namespace twin::onboard::onboard_limit_monitor_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Legal everywhere; tests put one value out of bounds.
JointReference Legal() {
  JointReference reference;
  reference.q_d = {0, -0.7, 0, -2.3, 0, 1.5, 0.7};
  return reference;
}

std::vector<RobotError> ErrorsOf(const JointReference& reference) {
  std::vector<RobotError> errors;
  const Violations found = CheckStep(reference, test::PandaLimits(), 42);
  for (const Violation& violation : found.items()) errors.push_back(violation.error);
  return errors;
}

TEST(LimitMonitorTest, PassesALegalStep) {
  EXPECT_THAT(ErrorsOf(Legal()), IsEmpty());
}

TEST(LimitMonitorTest, EveryLimitOfEveryJointIsCheckedOnBothSides) {
  const JointLimits limits = test::PandaLimits();
  struct Case {
    JointVector JointReference::*field;
    JointVector JointLimits::*limit;
    RobotError error;
  };
  const Case cases[] = {
      {&JointReference::dq_d, &JointLimits::dq_max,
       RobotError::kJointMotionGeneratorVelocityLimitsViolation},
      {&JointReference::ddq_d, &JointLimits::ddq_max,
       RobotError::kJointMotionGeneratorVelocityDiscontinuity},
      {&JointReference::dddq_d, &JointLimits::dddq_max,
       RobotError::kJointMotionGeneratorAccelerationDiscontinuity},
  };
  for (const Case& c : cases) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      for (const double sign : {-1.0, 1.0}) {
        JointReference reference = Legal();
        (reference.*c.field)[i] = sign * (limits.*c.limit)[i];
        EXPECT_THAT(ErrorsOf(reference), IsEmpty()) << "at the limit, joint " << i + 1;
        (reference.*c.field)[i] *= 1 + 1e-8;
        EXPECT_THAT(ErrorsOf(reference), ElementsAre(c.error)) << "beyond, joint " << i + 1;
        const Violations found = CheckStep(reference, limits, 42);
        const Violation& violation = found.items().front();
        EXPECT_EQ(violation.axis, static_cast<int>(i));
        EXPECT_EQ(violation.value, (reference.*c.field)[i]);
        EXPECT_EQ(violation.limit, sign * (limits.*c.limit)[i]);
        EXPECT_EQ(violation.message_id, 42u);
      }
    }
  }
}

TEST(LimitMonitorTest, ChecksThePositionRangeOfEveryJoint) {
  const JointLimits limits = test::PandaLimits();
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const double bound : {limits.q_min[i], limits.q_max[i]}) {
      JointReference reference = Legal();
      reference.q_d[i] = bound;
      EXPECT_THAT(ErrorsOf(reference), IsEmpty());
      reference.q_d[i] = bound + (bound == limits.q_max[i] ? 1e-7 : -1e-7);
      EXPECT_THAT(ErrorsOf(reference),
                  ElementsAre(RobotError::kJointMotionGeneratorPositionLimitsViolation));
    }
  }
}

TEST(LimitMonitorTest, ReportsADiscontinuityBeforeTheEnvelope) {
  JointReference reference = Legal();
  reference.dq_d[0] = 3;
  reference.q_d[1] = 2;
  EXPECT_THAT(ErrorsOf(reference),
              ElementsAre(RobotError::kJointMotionGeneratorVelocityLimitsViolation,
                          RobotError::kJointMotionGeneratorPositionLimitsViolation));
  reference.ddq_d[0] = 16;
  EXPECT_THAT(ErrorsOf(reference),
              ElementsAre(RobotError::kJointMotionGeneratorVelocityDiscontinuity));
  reference.dddq_d[3] = -7000;
  EXPECT_THAT(ErrorsOf(reference),
              ElementsAre(RobotError::kJointMotionGeneratorVelocityDiscontinuity,
                          RobotError::kJointMotionGeneratorAccelerationDiscontinuity));
}

TEST(LimitMonitorTest, AfterInverseKinematicsTheSameStepsRaiseTheErrorsOfCartesianMotions) {
  const auto errors_of = [](const JointReference& reference) {
    std::vector<RobotError> errors;
    const Violations found =
        CheckStep(reference, test::PandaLimits(), 42, kInverseKinematicsErrors);
    for (const Violation& violation : found.items()) errors.push_back(violation.error);
    return errors;
  };
  JointReference reference = Legal();
  EXPECT_THAT(errors_of(reference), IsEmpty());
  reference.dq_d[0] = 3;
  reference.q_d[1] = 2;
  EXPECT_THAT(errors_of(reference),
              ElementsAre(RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation,
                          RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation));
  reference.ddq_d[0] = 16;
  reference.dddq_d[3] = -7000;
  EXPECT_THAT(errors_of(reference),
              ElementsAre(RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity,
                          RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity));
}

TEST(LimitMonitorTest, NaNIsBeyondEveryLimit) {
  JointReference reference = Legal();
  reference.dddq_d[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorsOf(reference),
              ElementsAre(RobotError::kJointMotionGeneratorAccelerationDiscontinuity));
  reference = Legal();
  reference.q_d[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorsOf(reference),
              ElementsAre(RobotError::kJointMotionGeneratorPositionLimitsViolation));
}

TEST(LimitMonitorTest, TakesATorqueRateUpToTheLimitInBothDirections) {
  const JointLimits limits = test::PandaLimits();
  const JointVector tau_J_d{10, -20, 30, -40, 5, -6, 0};
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      JointVector tau_d = tau_J_d;
      tau_d[i] += sign * 1.0;  // 1000 Nm/s, but for rounding
      EXPECT_TRUE(CheckTorqueRate(tau_d, tau_J_d, limits, 7).empty());
      tau_d[i] += sign * 1e-6;
      const Violations found = CheckTorqueRate(tau_d, tau_J_d, limits, 7);
      ASSERT_EQ(found.items().size(), 1u);
      const Violation& violation = found.items()[0];
      EXPECT_EQ(violation.error, RobotError::kControllerTorqueDiscontinuity);
      EXPECT_EQ(violation.axis, static_cast<int>(i));
      EXPECT_NEAR(violation.value, sign * 1000.001, 1e-6);
      EXPECT_EQ(violation.limit, sign * 1000);
      EXPECT_EQ(violation.message_id, 7u);
    }
  }
}

TEST(LimitMonitorTest, ATorqueThatIsNoNumberIsADiscontinuity) {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const Violations found =
        CheckTorqueRate({0, 0, 0, 0, 0, value, 0}, JointVector{}, test::PandaLimits(), 1);
    ASSERT_EQ(found.items().size(), 1u);
    EXPECT_EQ(found.items()[0].axis, 5);
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_limit_monitor_test

#include "twin/onboard/cartesian_monitor.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "support/panda_limits.h"
#include "twin/model/transform.h"

namespace twin::onboard::onboard_cartesian_monitor_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr RobotError kVelocity = RobotError::kCartesianMotionGeneratorVelocityLimitsViolation;
constexpr RobotError kAcceleration = RobotError::kCartesianMotionGeneratorVelocityDiscontinuity;
constexpr RobotError kJerk = RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity;
constexpr RobotError kRange = RobotError::kCartesianMotionGeneratorElbowLimitViolation;

CartesianReference Legal() {
  return CartesianReference::Rest(kIdentityTransform, {0.3, -1});
}

Violations Check(const CartesianReference& reference, bool has_elbow = true) {
  return CheckCartesianStep(reference, has_elbow, test::PandaCartesianLimits(), test::PandaLimits(),
                            42);
}

double ValueOf(const Violations& found) {
  return found.items()[0].value;
}

std::vector<RobotError> ErrorsOf(const Violations& found) {
  std::vector<RobotError> errors;
  for (const Violation& violation : found.items()) errors.push_back(violation.error);
  return errors;
}

/// One derivative, where it is and what it may be.
struct Derivative {
  Vector6 CartesianReference::*pose;
  double CartesianReference::*elbow;
  double CartesianBound::*bound;
  RobotError error;
};
const Derivative kDerivatives[] = {
    {&CartesianReference::O_dP_EE_c, &CartesianReference::delbow_c, &CartesianBound::dp_max,
     kVelocity},
    {&CartesianReference::O_ddP_EE_c, &CartesianReference::ddelbow_c, &CartesianBound::ddp_max,
     kAcceleration},
    {&CartesianReference::O_dddP_EE_c, &CartesianReference::dddelbow_c, &CartesianBound::dddp_max,
     kJerk},
};

TEST(CartesianMonitorTest, TheNormOfTranslationAndRotationIsBounded) {
  const CartesianLimits limits = test::PandaCartesianLimits();
  const Eigen::Vector3d directions[] = {{1, 0, 0}, {0, -1, 0}, {0.6, 0, -0.8}, {2, -3, 6}};
  for (const Derivative& d : kDerivatives) {
    for (const Eigen::Vector3d& direction : directions) {
      for (const int axis : {0, 1}) {
        const double bound = (axis == 0 ? limits.translation : limits.rotation).*d.bound;
        const auto with = [&](double length) {
          CartesianReference reference = Legal();
          const Eigen::Vector3d x = length * direction.normalized();
          for (int i = 0; i < 3; ++i) {
            (reference.*d.pose)[3 * static_cast<std::size_t>(axis) + static_cast<std::size_t>(i)] =
                x[i];
          }
          return reference;
        };
        EXPECT_THAT(ErrorsOf(Check(with(bound))), IsEmpty());
        const Violations found = Check(with(bound * (1 + 1e-8)));
        ASSERT_THAT(ErrorsOf(found), ElementsAre(d.error));
        EXPECT_EQ(found.items()[0].axis, axis);
        EXPECT_NEAR(found.items()[0].value, bound * (1 + 1e-8), 1e-9 * bound);
        EXPECT_EQ(found.items()[0].limit, bound);
        EXPECT_EQ(found.items()[0].message_id, 42u);
      }
    }
  }
}

TEST(CartesianMonitorTest, TheElbowIsBoundedInBothDirectionsWhenCommanded) {
  const CartesianBound bounds = test::PandaCartesianLimits().elbow;
  for (const Derivative& d : kDerivatives) {
    for (const double sign : {-1.0, 1.0}) {
      CartesianReference reference = Legal();
      reference.*d.elbow = sign * bounds.*d.bound;
      EXPECT_THAT(ErrorsOf(Check(reference)), IsEmpty());
      reference.*d.elbow *= 1 + 1e-8;
      const Violations found = Check(reference);
      ASSERT_THAT(ErrorsOf(found), ElementsAre(d.error));
      EXPECT_EQ(found.items()[0].axis, 2);
      EXPECT_EQ(found.items()[0].value, reference.*d.elbow);
      EXPECT_EQ(found.items()[0].limit, sign * bounds.*d.bound);
      EXPECT_THAT(ErrorsOf(Check(reference, false)), IsEmpty());
    }
  }
}

TEST(CartesianMonitorTest, TheElbowStaysInTheRangeOfJointThree) {
  const JointLimits joints = test::PandaLimits();
  for (const double bound : {joints.q_min[2], joints.q_max[2]}) {
    CartesianReference reference = Legal();
    reference.elbow_c[0] = bound;
    EXPECT_THAT(ErrorsOf(Check(reference)), IsEmpty());
    reference.elbow_c[0] = bound * (1 + 1e-8);
    const Violations found = Check(reference);
    ASSERT_THAT(ErrorsOf(found), ElementsAre(kRange));
    EXPECT_EQ(found.items()[0].axis, 2);
    EXPECT_EQ(found.items()[0].limit, bound);
    EXPECT_THAT(ErrorsOf(Check(reference, false)), IsEmpty());
  }
}

TEST(CartesianMonitorTest, ReportsADiscontinuityBeforeTheEnvelope) {
  CartesianReference reference = Legal();
  reference.O_dP_EE_c[0] = 3;
  reference.elbow_c[0] = 3;
  EXPECT_THAT(ErrorsOf(Check(reference)), ElementsAre(kVelocity, kRange));
  reference.O_ddP_EE_c[4] = 30;
  EXPECT_THAT(ErrorsOf(Check(reference)), ElementsAre(kAcceleration));
  reference.O_dddP_EE_c[1] = 7000;
  EXPECT_THAT(ErrorsOf(Check(reference)), ElementsAre(kAcceleration, kJerk));
}

TEST(CartesianMonitorTest, WhatIsNoNumberBreaksEveryLimit) {
  for (const Derivative& d : kDerivatives) {
    for (const std::size_t i : {1, 3}) {
      CartesianReference reference = Legal();
      (reference.*d.pose)[i] = kNaN;
      EXPECT_THAT(ErrorsOf(Check(reference)), ElementsAre(d.error));
    }
    CartesianReference reference = Legal();
    reference.*d.elbow = kNaN;
    EXPECT_THAT(ErrorsOf(Check(reference)), ElementsAre(d.error));
  }
  CartesianReference reference = Legal();
  reference.elbow_c[0] = kNaN;
  EXPECT_THAT(ErrorsOf(Check(reference)), ElementsAre(kRange));
}

TEST(CartesianMonitorTest, APoseThatIsNoTransformIsAnInvalidFrame) {
  const Transform X = model::Pose(Eigen::Quaterniond(0.3, 0.5, -0.7, 0.2).normalized(), {1, 2, 3});
  EXPECT_TRUE(CheckFrame(X, 1).empty());
  struct Case {
    std::size_t element;
    double value;
    double deviation;
  };
  const Case cases[] = {
      {3, 1e-3, 1e-3},
      {15, 0, 1},
      {15, 1.1, 0.1},
      {12, kNaN, kNaN},
      {5, kNaN, kNaN},
      {14, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}};
  for (const Case& c : cases) {
    Transform wrong = X;
    wrong[c.element] = c.value;
    const Violations found = CheckFrame(wrong, 5);
    ASSERT_EQ(found.items().size(), 1u);
    const Violation& violation = found.items()[0];
    EXPECT_EQ(violation.error, RobotError::kCartesianPositionMotionGeneratorInvalidFrame);
    EXPECT_EQ(violation.axis, -1);
    EXPECT_EQ(violation.message_id, 5u);
    EXPECT_EQ(violation.limit, 1e-5);
    if (std::isnan(c.deviation)) {
      EXPECT_TRUE(std::isnan(violation.value));
    } else {
      EXPECT_TRUE(violation.value == c.deviation ||
                  std::abs(violation.value - c.deviation) < 1e-15);
    }
  }
}

TEST(CartesianMonitorTest, ARotationIsOrthonormalWithinATolerance) {
  Transform X = kIdentityTransform;
  X[0] = 1 + 4e-6;  // squared: 8e-6
  EXPECT_TRUE(CheckFrame(X, 1).empty());
  X[0] = 1 + 6e-6;
  ASSERT_FALSE(CheckFrame(X, 1).empty());
  EXPECT_NEAR(ValueOf(CheckFrame(X, 1)), 1.2e-5, 1e-9);
  Transform row_major = kIdentityTransform;  // translation where the last row belongs
  row_major[3] = 0.3;
  EXPECT_NEAR(ValueOf(CheckFrame(row_major, 1)), 0.3, 1e-15);
  Transform mirrored = kIdentityTransform;
  mirrored[10] = -1;
  EXPECT_NEAR(ValueOf(CheckFrame(mirrored, 1)), 2, 1e-15);
}

constexpr StartTolerance kTolerance{.translation_m = 0.05, .rotation_rad = 0.1, .elbow_rad = 0.1};

TEST(CartesianMonitorTest, TheFirstPoseIsNearInTranslationAndRotation) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(2, Eigen::Vector3d(1, 2, -1).normalized()));
  const Transform last = model::Pose(q, {0.3, 0.1, 0.5});
  const auto at = [&](double distance, double angle) {
    const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, -2) / 3;
    return model::Turned(last, angle * direction, model::Position(last) + distance * direction);
  };
  EXPECT_TRUE(CheckStartPose(at(0.0499999, 0.0999999), last, kTolerance, 1).empty());
  const Violations far = CheckStartPose(at(0.051, 0.2), last, kTolerance, 1);
  ASSERT_EQ(far.items().size(), 1u);
  EXPECT_EQ(far.items()[0].error, RobotError::kCartesianPositionMotionGeneratorStartPoseInvalid);
  EXPECT_EQ(far.items()[0].axis, 0);
  EXPECT_NEAR(far.items()[0].value, 0.051, 1e-12);
  EXPECT_EQ(far.items()[0].limit, 0.05);
  const Violations turned = CheckStartPose(at(0.049, 3), last, kTolerance, 1);
  ASSERT_EQ(turned.items().size(), 1u);
  EXPECT_EQ(turned.items()[0].axis, 1);
  EXPECT_NEAR(turned.items()[0].value, 3, 1e-12);
  EXPECT_EQ(turned.items()[0].limit, 0.1);
}

TEST(CartesianMonitorTest, TheFirstElbowIsNear) {
  EXPECT_TRUE(CheckStartElbow(0.4, 0.3, kTolerance, 1).empty());
  EXPECT_TRUE(CheckStartElbow(0.2, 0.3, kTolerance, 1).empty());
  for (const double elbow : {0.41, 0.19, kNaN}) {
    const Violations found = CheckStartElbow(elbow, 0.3, kTolerance, 1);
    ASSERT_EQ(found.items().size(), 1u);
    EXPECT_EQ(found.items()[0].error, RobotError::kCartesianMotionGeneratorStartElbowInvalid);
    EXPECT_EQ(found.items()[0].axis, 2);
  }
}

TEST(CartesianMonitorTest, TheElbowsSignIsTheArms) {
  EXPECT_TRUE(CheckElbowSign(-1, -1, 1).empty());
  EXPECT_TRUE(CheckElbowSign(1, 1, 1).empty());
  const double wrong[][2] = {{1, -1}, {-1, 1}, {0, -1}, {0, 0}, {-0.5, -1}, {2, 1}, {kNaN, -1}};
  for (const auto& [commanded, arm] : wrong) {
    const Violations found = CheckElbowSign(commanded, arm, 1);
    ASSERT_EQ(found.items().size(), 1u) << commanded << " for " << arm;
    EXPECT_EQ(found.items()[0].error, RobotError::kCartesianMotionGeneratorElbowSignInconsistent);
    EXPECT_EQ(found.items()[0].axis, -1);
    EXPECT_EQ(found.items()[0].limit, arm);
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_cartesian_monitor_test

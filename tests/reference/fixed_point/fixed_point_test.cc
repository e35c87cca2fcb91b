#include "reference/fixed_point/fixed_point.h"

#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "twin/core/time.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference::fixed_point_test {
namespace {

constexpr double kT = kCycleSeconds;

ViableAxis PandaAxis(std::size_t joint, int lost) {
  return ViableAxis(BoundsOf(test::PandaLimits(), joint), lost, "joint");
}

/// Bounds of the first joint with a range so small that few steps are needed.
AxisBounds SmallBounds(double range) {
  return {-range / 2, range / 2, 2.175, 15, 7500};
}

TEST(FixedPointTest, AScaledStepIsAStep) {
  const AxisBounds bounds = BoundsOf(test::PandaLimits(), 3);
  const ScaledJoint joint(bounds);
  const AxisState x{-1.3, 0.7, -5};
  const double u = 0.4;
  const AxisState next = ViableAxis::Step(x, u * bounds.dddq_max);
  const AxisState scaled = joint.Unscaled(joint.A * joint.Scaled(x) + u * joint.b);
  EXPECT_NEAR(scaled.q, next.q, 1e-14);
  EXPECT_NEAR(scaled.dq, next.dq, 1e-14);
  EXPECT_NEAR(scaled.ddq, next.ddq, 1e-13);
}

TEST(FixedPointTest, WithoutLossesASpeedIsLeftInTimeToStop) {
  // The acceleration falls to -A in two commands and rises from it in two; between them the joint
  // goes v^2 / (2 A), but for the way of a cycle or two.
  const ViableAxis axis = PandaAxis(6, 0);
  const FixedPoint found = FixedPointOf(axis.kept(), 0);
  const ScaledJoint joint(axis.kept());
  const double v = 0.9 * axis.kept().dq_max;
  const double way = v * v / (2 * axis.kept().ddq_max);
  const double cycles = 2 * kT * v;
  EXPECT_GT(found.set.Excess(joint.Scaled({axis.kept().q_max - way + cycles, v, 0})), 1e-6);
  EXPECT_LT(found.set.Excess(joint.Scaled({axis.kept().q_max - way - cycles, v, 0})), -1e-6);
}

TEST(FixedPointTest, IsTheClosedForm) {
  for (const int lost : {3, 19}) {
    const ViableAxis axis = PandaAxis(6, lost);
    const FixedPoint found = FixedPointOf(axis.kept(), lost);
    EXPECT_LT(found.residual, 1e-10);
    const Agreement agreement = Compare(found, axis, 20000, 7);
    EXPECT_EQ(agreement.disagreements, 0U) << "n = " << lost;
    EXPECT_GT(agreement.viable, 4000U);
    EXPECT_LT(agreement.viable, 16000U);
    EXPECT_GT(agreement.near_border, 10000U);
  }
}

TEST(FixedPointTest, IsTheClosedFormWhereJerkAndAccelerationAreInAnotherRatio) {
  // The Panda's acceleration is two commands from zero to its limit; here five and a bit, and less
  // than one.
  for (const double jerk : {2800.0, 40000.0}) {
    const ViableAxis axis({-0.6, 0.6, 1.1, 15, jerk}, 7, "joint");
    const Agreement agreement = Compare(FixedPointOf(axis.kept(), 7), axis, 20000, 11);
    EXPECT_EQ(agreement.disagreements, 0U) << jerk;
    EXPECT_GT(agreement.viable, 4000U);
  }
}

TEST(FixedPointTest, IsNotThatOfAnotherN) {
  const ViableAxis axis = PandaAxis(6, 19);
  const FixedPoint found = FixedPointOf(axis.kept(), 18);
  EXPECT_GT(Compare(found, axis, 20000, 7).disagreements, 10U);
}

TEST(FixedPointTest, IsTheClosedFormInTheSmallestRangeThatIsAdmitted) {
  for (const int lost : {3, 19}) {
    const double least = ViableAxis(SmallBounds(1), lost, "joint").least_range();
    const ViableAxis axis(SmallBounds(least + 3e-6), lost, "joint");
    const Agreement agreement = Compare(FixedPointOf(axis.kept(), lost), axis, 20000, 9);
    EXPECT_EQ(agreement.disagreements, 0U) << "n = " << lost;
    EXPECT_GT(agreement.viable, 1000U);
  }
}

TEST(FixedPointTest, NoSmallerRangeIsEnough) {
  for (const int lost : {0, 3, 19}) {
    const ViableAxis axis(SmallBounds(1), lost, "joint");
    EXPECT_NEAR(LeastRange(axis.kept(), lost) / axis.least_range(), 1, 1e-5) << "n = " << lost;
  }
}

}  // namespace
}  // namespace twin::reference::fixed_point_test

#include "twin/onboard/joint_reference.h"

#include <cmath>

#include <gtest/gtest.h>

namespace twin::onboard::onboard_joint_reference_test {
namespace {

constexpr double kT = 1e-3;

JointReference Moving() {
  JointReference reference;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double k = static_cast<double>(i + 1);
    reference.q_d[i] = 0.1 * k;
    reference.dq_d[i] = 0.05 * k;
    reference.ddq_d[i] = -0.2 * k;
  }
  return reference;
}

TEST(JointReferenceTest, FormsBackwardDifferencesOfACommandedPosition) {
  const JointReference last = Moving();
  JointVector q_c = last.q_d;
  q_c[2] += 2e-4;
  const JointReference next = last.AfterPosition(q_c);
  EXPECT_DOUBLE_EQ(next.q_d[2], q_c[2]);
  EXPECT_NEAR(next.dq_d[2], 0.2, 1e-12);
  EXPECT_NEAR(next.ddq_d[2], (0.2 - 0.15) / kT, 1e-9);
  EXPECT_NEAR(next.dddq_d[2], (50.0 + 0.6) / kT, 1e-6);
}

TEST(JointReferenceTest, IntegratesACommandedVelocity) {
  const JointReference last = Moving();
  JointVector dq_c = last.dq_d;
  dq_c[0] = 0.06;
  const JointReference next = last.AfterVelocity(dq_c);
  EXPECT_DOUBLE_EQ(next.dq_d[0], 0.06);
  EXPECT_NEAR(next.q_d[0], 0.1 + kT * 0.06, 1e-15);
  EXPECT_NEAR(next.ddq_d[0], 10.0, 1e-9);
}

TEST(JointReferenceTest, HoldsTheAccelerationOverALoss) {
  // n held cycles: v_n = v + n T a, q_n = q + n T v + T^2 a n (n + 1) / 2.
  JointReference reference = Moving();
  const JointReference first = reference;
  constexpr int kLost = 19;
  for (int n = 0; n < kLost; ++n) reference = reference.AfterLoss();
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double v = first.dq_d[i];
    const double a = first.ddq_d[i];
    EXPECT_NEAR(reference.dq_d[i], v + kLost * kT * a, 1e-12);
    EXPECT_NEAR(reference.q_d[i],
                first.q_d[i] + kLost * kT * v + kT * kT * a * kLost * (kLost + 1) / 2, 1e-12);
    EXPECT_EQ(reference.ddq_d[i], a);
    EXPECT_EQ(reference.dddq_d[i], 0);
  }
}

TEST(JointReferenceTest, IsAtRestOnlyWithoutVelocityAndAcceleration) {
  JointReference reference = JointReference::Rest({1, 2, 3, 4, 5, 6, 7});
  EXPECT_TRUE(reference.AtRest());
  reference.dq_d[6] = 1e-300;
  EXPECT_FALSE(reference.AtRest());
  reference = JointReference::Rest({});
  reference.ddq_d[0] = -1e-300;
  EXPECT_FALSE(reference.AtRest());
}

}  // namespace
}  // namespace twin::onboard::onboard_joint_reference_test

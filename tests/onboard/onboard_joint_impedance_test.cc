#include "twin/onboard/joint_impedance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "onboard/control_torque.h"

namespace twin::onboard::onboard_joint_impedance_test {
namespace {

constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};
constexpr JointVector kStiffness{3000, 3000, 3000, 2500, 2500, 2000, 2000};
constexpr JointVector kRotor{0.6, 0.6, 0.46, 0.46, 0.2, 0.2, 0.2};

TEST(JointImpedanceTest, AtRestOnTheReferenceItAppliesGravityAlone) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  const model::Payload hand{0.73, {-0.01, 0, 0.03}, {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};
  const JointImpedance impedance(kStiffness, 1.0, kRotor);
  const JointSensors sensors{kReady, {}, {}, kReady, {}};
  const ImpedanceTorque torque =
      ControlTorque(impedance, JointReference::Rest(kReady), sensors, {.payload = hand});
  const JointVector g = arm.Gravity(kReady, hand);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(torque.tau_J_d[i], 0, 1e-12);
    EXPECT_NEAR(torque.tau[i], g[i], 1e-12);
  }
}

TEST(JointImpedanceTest, ADeflectionMeetsTheStiffness) {
  const JointImpedance impedance(kStiffness, 1.0, kRotor);
  JointReference reference = JointReference::Rest(kReady);
  for (double& q_d : reference.q_d) q_d += 0.01;
  const ImpedanceTorque torque =
      ControlTorque(impedance, reference, {kReady, {}, {}, kReady, {}}, {});
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(torque.tau_J_d[i], 0.01 * kStiffness[i], 1e-9);
  }
}

TEST(JointImpedanceTest, FeedsTheAccelerationForwardThroughTheInertia) {
  // tau_J_d = (M + B) ddq_d when there is no error and no velocity.
  const model::ArmModel& arm = model::ArmModel::Panda();
  const JointImpedance impedance(kStiffness, 1.0, kRotor);
  JointReference reference = JointReference::Rest(kReady);
  reference.ddq_d = {1, -2, 3, -1, 2, -3, 1};
  const ImpedanceTorque torque =
      ControlTorque(impedance, reference, {kReady, {}, {}, kReady, {}}, {});
  const model::JointMatrix M = arm.MassMatrix(kReady, {});
  for (std::size_t i = 0; i < kJoints; ++i) {
    double expected = kRotor[i] * reference.ddq_d[i];
    for (std::size_t j = 0; j < kJoints; ++j) expected += M[kJoints * j + i] * reference.ddq_d[j];
    EXPECT_NEAR(torque.tau_J_d[i], expected, 1e-9);
  }
}

TEST(JointImpedanceTest, DampsCritically) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  const JointImpedance impedance(kStiffness, 1.0, kRotor);
  JointReference reference = JointReference::Rest(kReady);
  reference.dq_d[3] = 0.1;
  const ImpedanceTorque torque =
      ControlTorque(impedance, reference, {kReady, {}, {}, kReady, {}}, {});
  const model::JointMatrix M = arm.MassMatrix(kReady, {});
  const double inertia = M[kJoints * 3 + 3] + kRotor[3];
  EXPECT_NEAR(torque.tau_J_d[3], 0.1 * 2 * std::sqrt(kStiffness[3] * inertia), 1e-9);
  EXPECT_NEAR(torque.tau_J_d[0], 0, 1e-12);
}

}  // namespace
}  // namespace twin::onboard::onboard_joint_impedance_test

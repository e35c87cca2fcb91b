#pragma once

#include <Eigen/Dense>

#include "twin/core/joint_interface.h"
#include "twin/model/arm_model.h"

namespace twin::test {

/// A frictionless arm for tests of INT, made of the very model INT uses, so that its gravity
/// compensation is exact: (M(q) + B) ddq = tau - c(q, dq) - g(q), integrated by semi-implicit Euler
/// at 1 ms. What acts on it from outside comes on top of tau.
class RigidArm {
 public:
  RigidArm(const JointVector& q, const model::Payload& payload, const JointVector& rotor_inertia)
      : payload_(payload), rotor_inertia_(rotor_inertia), sensors_{q, {}, {}, q, {}} {
    sensors_.tau_J = model::ArmModel::Panda().Gravity(q, payload_);
  }

  /// @param tau_outside  of forces from outside, as J^T of the force on the arm, Nm.
  void Step(const JointDrive& drive, const JointVector& tau_outside = {}) {
    const model::ArmModel& arm = model::ArmModel::Panda();
    using Matrix = Eigen::Matrix<double, kJoints, kJoints>;
    using Vector = Eigen::Matrix<double, kJoints, 1>;
    Matrix M = Eigen::Map<const Matrix>(arm.MassMatrix(sensors_.q, payload_).data());
    const JointVector bias = arm.InverseDynamics(sensors_.q, sensors_.dq, JointVector{}, payload_);
    Vector tau;
    for (std::size_t i = 0; i < kJoints; ++i) {
      M(i, i) += rotor_inertia_[i];
      tau(i) = drive.tau[i] + tau_outside[i] - bias[i];
    }
    const Vector ddq = M.ldlt().solve(tau);
    for (std::size_t i = 0; i < kJoints; ++i) {
      ddq_[i] = ddq(i);
      sensors_.dq[i] += 1e-3 * ddq(i);
      sensors_.q[i] += 1e-3 * sensors_.dq[i];
      sensors_.tau_J[i] = drive.tau[i] - rotor_inertia_[i] * ddq(i);
    }
  }

  [[nodiscard]] const JointSensors& sensors() const { return sensors_; }
  [[nodiscard]] const JointVector& ddq() const { return ddq_; }

 private:
  model::Payload payload_;
  JointVector rotor_inertia_;
  JointSensors sensors_;
  JointVector ddq_{};
};

}  // namespace twin::test

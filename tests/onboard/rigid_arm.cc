#include "onboard/rigid_arm.h"

#include <Eigen/Cholesky>

namespace twin::test {

RigidArm::RigidArm(const JointVector& q, const model::Payload& payload,
                   const JointVector& rotor_inertia)
    : payload_(payload), rotor_inertia_(rotor_inertia), sensors_{q, {}, {}, q, {}} {
  sensors_.tau_J = model::ArmModel::Panda().Gravity(q, payload_);
}

void RigidArm::Step(const JointDrive& drive, const JointVector& tau_outside) {
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

}  // namespace twin::test

#pragma once

#include "twin/core/body_interface.h"
#include "twin/model/arm_model.h"

namespace twin::test {

/// A frictionless arm for tests of INT, made of the very model INT uses, so that its gravity
/// compensation is exact: (M(q) + B) ddq = tau - c(q, dq) - g(q), integrated by semi-implicit Euler
/// at 1 ms. What acts on it from outside comes on top of tau.
class RigidArm {
 public:
  RigidArm(const JointVector& q, const model::Payload& payload, const JointVector& rotor_inertia);

  /// @param tau_outside  of forces from outside, as J^T of the force on the arm, Nm.
  void Step(const JointDrive& drive, const JointVector& tau_outside = {});

  [[nodiscard]] const JointSensors& sensors() const { return sensors_; }
  [[nodiscard]] const JointVector& ddq() const { return ddq_; }

 private:
  model::Payload payload_;
  JointVector rotor_inertia_;
  JointSensors sensors_;
  JointVector ddq_{};
};

}  // namespace twin::test

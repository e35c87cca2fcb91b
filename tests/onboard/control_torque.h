#pragma once

#include "twin/onboard/cartesian_impedance.h"
#include "twin/onboard/guiding.h"
#include "twin/onboard/joint_impedance.h"

// Torques of INT's controllers for an arm that is where the sensors show it.
namespace twin::onboard {

inline ImpedanceTorque ControlTorque(const JointImpedance& impedance,
                                     const JointReference& reference, const JointSensors& sensors,
                                     const ArmSetup& setup) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  return impedance.Torque(reference, sensors, MeasuredArm(arm, sensors.q, setup), arm, setup);
}

inline ImpedanceTorque ControlTorque(const CartesianImpedance& impedance,
                                     const JointReference& reference, const JointSensors& sensors,
                                     const ArmSetup& setup) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  const Transform O_T_EE_d = arm.Pose(model::Frame::kEndEffector, reference.q_d, setup.F_T_EE);
  return impedance.Torque(reference, O_T_EE_d, sensors, MeasuredArm(arm, sensors.q, setup), arm,
                          setup);
}

inline ImpedanceTorque ControlTorque(Guiding& guiding, const JointSensors& sensors,
                                     const ArmSetup& setup) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  return guiding.Torque(sensors, MeasuredArm(arm, sensors.q, setup), arm, setup);
}

}  // namespace twin::onboard

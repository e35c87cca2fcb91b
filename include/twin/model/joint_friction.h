#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::model {

/// Residual link-side friction of the Panda's joints, after the robot's own compensation of motor
/// and gear:
///   tau_f(dq) = phi1 / (1 + exp(-phi2 (dq + phi3))) - phi1 / (1 + exp(-phi2 phi3)),
/// opposed to dq, zero at rest and smooth there. Source: Gaz, Cognetti, Oliva, Robuffo Giordano,
/// De Luca, "Dynamic Identification of the Franka Emika Panda Robot with Retrieval of Feasible
/// Parameters Using Penalty-Based Optimization", RA-L 2019, supplementary material.
///
/// Threads: any (stateless). Real-time: noexcept, allocates nothing.
/// @param dq  7, joint order, rad/s. @returns friction torque that opposes the motion, Nm.
[[nodiscard]] JointVector ResidualFriction(const JointVector& dq) noexcept TWIN_REALTIME;

}  // namespace twin::model

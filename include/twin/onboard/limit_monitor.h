#pragma once

#include <cstdint>

#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/violations.h"

namespace twin::onboard {

/// The errors a step of a joint reference can raise, each by its own cause.
struct StepErrors {
  RobotError position = RobotError::kJointMotionGeneratorPositionLimitsViolation;
  RobotError velocity = RobotError::kJointMotionGeneratorVelocityLimitsViolation;
  RobotError acceleration = RobotError::kJointMotionGeneratorVelocityDiscontinuity;
  RobotError jerk = RobotError::kJointMotionGeneratorAccelerationDiscontinuity;
};

/// Those of a Cartesian motion, after inverse kinematics.
inline constexpr StepErrors kInverseKinematicsErrors{
    .position = RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation,
    .velocity = RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation,
    .acceleration = RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity,
    .jerk = RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity};

/// Checks one step of a joint reference against the limits.
///
/// Precedence: discontinuity before envelope. When acceleration or jerk is beyond its limit, the
/// errors of those two are reported, each by its own cause (a step breaks both), and position and
/// velocity are not looked at: they are consequences. Otherwise velocity and position are checked,
/// each for itself. Source: FCI protocol 5, error table and conditions.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
///
/// @param next        the step's result, its dddq_d filled.
/// @param message_id  id the violations carry.
/// @param errors      a joint generator's, unless told.
[[nodiscard]] Violations CheckStep(const JointReference& next, const JointLimits& limits,
                                   std::uint64_t message_id,
                                   const StepErrors& errors = {}) noexcept TWIN_REALTIME;

/// Checks the torque of an external controller: |tau_d - tau_J_d| / T <= dtau_max, joint by joint,
/// else controller_torque_discontinuity with the rate as its value. What is not finite breaks it.
/// The magnitude |tau_d| is not checked: FCI recommends tau_max, it does not enforce it. Source:
/// FCI protocol 5, conditions.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
///
/// @param tau_d    commanded, Nm.
/// @param tau_J_d  as the last robot state reports it, Nm.
[[nodiscard]] Violations CheckTorqueRate(const JointVector& tau_d, const JointVector& tau_J_d,
                                         const JointLimits& limits,
                                         std::uint64_t message_id) noexcept TWIN_REALTIME;

}  // namespace twin::onboard

#pragma once

#include <cstdint>

#include "twin/core/limits.h"
#include "twin/core/realtime.h"
#include "twin/onboard/joint_reference.h"
#include "twin/onboard/violations.h"

namespace twin::onboard {

/// Errors that a step of a joint reference can raise, one per check.
struct StepErrors {
  RobotError position = RobotError::kJointMotionGeneratorPositionLimitsViolation;
  RobotError velocity = RobotError::kJointMotionGeneratorVelocityLimitsViolation;
  RobotError acceleration = RobotError::kJointMotionGeneratorVelocityDiscontinuity;
  RobotError jerk = RobotError::kJointMotionGeneratorAccelerationDiscontinuity;
};

/// Errors of a Cartesian motion, after inverse kinematics.
inline constexpr StepErrors kInverseKinematicsErrors{
    .position = RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation,
    .velocity = RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation,
    .acceleration = RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity,
    .jerk = RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity};

/// Checks one step of a joint reference against the limits.
///
/// Precedence: discontinuity before envelope. When acceleration or jerk exceeds its limit, only
/// these two are reported (a step breaks both), since excess position and velocity are
/// consequences. Otherwise velocity and position are checked independently; a velocity limit that
/// depends on the position is that at the position before the step. Source: FCI protocol 5, error
/// table and conditions.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
///
/// @param next        result of the step, including dddq_d.
/// @param message_id  id of the violations.
/// @param errors      by default those of a joint generator.
[[nodiscard]] Violations CheckStep(const JointReference& next, const JointLimits& limits,
                                   std::uint64_t message_id,
                                   const StepErrors& errors = {}) noexcept TWIN_REALTIME;

/// Checks the torque of an external controller per joint: |tau_d - tau_J_d| / T <= dtau_max, else
/// controller_torque_discontinuity with the rate as its value. A value that is not finite violates
/// it. The magnitude |tau_d| is not checked: FCI recommends tau_max but does not enforce it.
/// Source: FCI protocol 5, conditions.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
///
/// @param tau_d    commanded, Nm.
/// @param tau_J_d  in the last robot state, Nm.
[[nodiscard]] Violations CheckTorqueRate(const JointVector& tau_d, const JointVector& tau_J_d,
                                         const JointLimits& limits,
                                         std::uint64_t message_id) noexcept TWIN_REALTIME;

}  // namespace twin::onboard

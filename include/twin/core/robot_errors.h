#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <string>
#include <string_view>

namespace twin {

/// The 41 errors of the robot's controller; the value is the index into `errors` and
/// `reflex_reason` of the robot state. Comments give the cause. Source: FCI protocol 5, error
/// table.
enum class RobotError : std::uint8_t {
  kJointPositionLimitsViolation = 0,      ///< measured joint position beyond its limit
  kCartesianPositionLimitsViolation = 1,  ///< virtual wall
  kSelfCollisionAvoidanceViolation = 2,   ///< configuration about to self-collide
  kJointVelocityViolation = 3,            ///< measured joint velocity above its limit
  kCartesianVelocityViolation = 4,        ///< measured Cartesian velocity above its limit
  kForceControlSafetyViolation = 5,       ///< safety threshold exceeded in force control
  kJointReflex = 6,                       ///< external joint torque above the upper threshold
  kCartesianReflex = 7,                   ///< external Cartesian force above the upper threshold
  kMaxGoalPoseDeviationViolation = 8,     ///< internal generator missed its goal
  kMaxPathPoseDeviationViolation = 9,     ///< internal generator left its path
  kCartesianVelocityProfileSafetyViolation =
      10,  ///< velocity profile of an internal motion exceeded
  kJointPositionMotionGeneratorStartPoseInvalid =
      11,  ///< first q_c too far from the current position
  kJointMotionGeneratorPositionLimitsViolation =
      12,  ///< commanded joint position outside its limits
  kJointMotionGeneratorVelocityLimitsViolation = 13,  ///< commanded joint velocity above its limit
  kJointMotionGeneratorVelocityDiscontinuity =
      14,  ///< commanded joint acceleration above its limit
  kJointMotionGeneratorAccelerationDiscontinuity = 15,  ///< commanded joint jerk above its limit
  kCartesianPositionMotionGeneratorStartPoseInvalid = 16,
  kCartesianMotionGeneratorElbowLimitViolation = 17,
  kCartesianMotionGeneratorVelocityLimitsViolation = 18,
  kCartesianMotionGeneratorVelocityDiscontinuity = 19,
  kCartesianMotionGeneratorAccelerationDiscontinuity = 20,
  kCartesianMotionGeneratorElbowSignInconsistent = 21,
  kCartesianMotionGeneratorStartElbowInvalid = 22,
  kForceControllerDesiredForceToleranceViolation = 23,
  kStartElbowSignInconsistent = 24,
  kCommunicationConstraintsViolation = 25,  ///< 20 consecutive command packets lost
  kPowerLimitViolation = 26,
  kCartesianMotionGeneratorJointPositionLimitsViolation = 27,
  kCartesianMotionGeneratorJointVelocityLimitsViolation = 28,
  kCartesianMotionGeneratorJointVelocityDiscontinuity = 29,
  kCartesianMotionGeneratorJointAccelerationDiscontinuity = 30,
  kCartesianPositionMotionGeneratorInvalidFrame = 31,
  kControllerTorqueDiscontinuity = 32,  ///< commanded torque rate above its limit
  kJointP2pInsufficientTorqueForPlanning = 33,
  kTauJRangeViolation = 34,
  kInstabilityDetected = 35,
  kJointMoveInWrongDirection = 36,
  kCartesianSplineMotionGeneratorViolation = 37,
  kJointViaMotionGeneratorPlanningJointLimitViolation = 38,
  kBaseAccelerationInitializationTimeout = 39,
  kBaseAccelerationInvalidReading = 40,
};

/// Number of errors.
inline constexpr std::size_t kRobotErrorCount = 41;

/// A set of errors, indexed by RobotError.
using RobotErrors = std::bitset<kRobotErrorCount>;

/// Name as clients of the real robot print it. Index 31 ends in `_flag`; index 34 has a capital J.
[[nodiscard]] std::string_view Name(RobotError error) noexcept;

/// Names of all errors in the set, as libfranka prints them: `["name_a", "name_b"]`.
[[nodiscard]] std::string FormatErrors(const RobotErrors& errors);

/// Details of an error that the real robot only names: the value that broke a limit, where and
/// when. Trivially copyable; created in the cycle.
struct Violation {
  RobotError error{};
  /// Meaning by error (AxisKind in error_catalogue.h): joint 0..6; 0 translation, 1 rotation, 2
  /// elbow; 0..5 = x y z R P Y of K; -1 without a single axis. For communication errors: 0 when a
  /// motion's first command did not arrive, -1 when too many consecutive commands were lost.
  std::int8_t axis = -1;
  double value = 0;              ///< the offending value, in the unit of `limit`
  double limit = 0;              ///< the bound it broke, signed like the value
  std::uint64_t message_id = 0;  ///< id of the robot state of the cycle that raised it
};

/// One sentence: error, joint or axis, value, limit, unit, cycle, and how the value was computed.
/// error_catalogue.h has cause and cure.
[[nodiscard]] std::string Describe(const Violation& violation);

}  // namespace twin

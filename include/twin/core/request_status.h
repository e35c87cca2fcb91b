#pragma once

#include <cstdint>

// Replies of the robot to requests. Values are those of the wire. Source: FCI protocol 5, status
// values.
namespace twin {

/// To Move, which has two replies if the motion starts: kMotionStarted, then how it ended.
enum class MoveStatus : std::uint8_t {
  kSuccess = 0,
  kMotionStarted = 1,
  kPreempted = 2,
  kCommandNotPossibleRejected = 3,
  kStartAtSingularPoseRejected = 4,
  kInvalidArgumentRejected = 5,
  kReflexAborted = 6,
  kEmergencyAborted = 7,
  kInputErrorAborted = 8,
  kAborted = 9,
};

/// To StopMove.
enum class StopStatus : std::uint8_t {
  kSuccess = 0,
  kCommandNotPossibleRejected = 1,
  kEmergencyAborted = 2,
  kReflexAborted = 3,
  kAborted = 4,
};

/// To a setter, and to GetCartesianLimit.
enum class SetterStatus : std::uint8_t {
  kSuccess = 0,
  kCommandNotPossibleRejected = 1,
  kInvalidArgumentRejected = 2,
};

/// To automatic error recovery.
enum class RecoveryStatus : std::uint8_t {
  kSuccess = 0,
  kCommandNotPossibleRejected = 1,
  kManualErrorRecoveryRequiredRejected = 2,
  kReflexAborted = 3,
  kEmergencyAborted = 4,
  kAborted = 5,
};

}  // namespace twin

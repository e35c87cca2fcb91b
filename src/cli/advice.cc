#include "cli/advice.h"

namespace twin::cli {

std::string_view Advice(RobotError error) noexcept {
  switch (error) {
    case RobotError::kCommunicationConstraintsViolation:
      return "too many commands in a row came late or not at all: a command counts only when state "
             "delay + tick.cost + command delay + link.d_INT stay below 1 ms; lower the delays or "
             "the losses";
    case RobotError::kJointPositionMotionGeneratorStartPoseInvalid:
      return "let the trajectory start where the robot is (robot.q_start), or leave q_start out";
    case RobotError::kJointPositionLimitsViolation:
    case RobotError::kJointMotionGeneratorPositionLimitsViolation:
      return "keep the trajectory further away from the joint's position limit";
    case RobotError::kJointVelocityViolation:
    case RobotError::kJointMotionGeneratorVelocityLimitsViolation:
      return "give the trajectory more time";
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity:
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity:
      return "the commands that reached the robot were not smooth. Raw streams need tick.generator "
             "joint, slow sources tick.rate_matching true; behind both, what remains comes from "
             "lost messages (link) and from deposits that slide through the cycles "
             "(controller.phase, clock_drift, wake_delay): fewer of them, or a gentler trajectory";
    case RobotError::kControllerTorqueDiscontinuity:
      return "the torque may change by 1 Nm per cycle: begin at the state's tau_J_d, lower the "
             "controller's gains, or say tick.limiter: true";
    case RobotError::kTauJRangeViolation:
      return "a torque sensor measured more than its range: lower the torques, or see what the arm "
             "ran into";
    default: return "see the plots and the log for what led to it";
  }
}

}  // namespace twin::cli

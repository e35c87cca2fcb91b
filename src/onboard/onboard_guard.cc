#include "twin/onboard/onboard_controller.h"

// The guard of OnboardController: limits of a lab.

namespace twin::onboard {
namespace {

/// The error of FCI protocol 5 by which a client learns of a broken limit.
RobotError ErrorOf(LimitKind kind) noexcept {
  switch (kind) {
    case LimitKind::kRegion: return RobotError::kCartesianPositionLimitsViolation;
    case LimitKind::kSpeed:
    case LimitKind::kTurn: return RobotError::kCartesianVelocityViolation;
    case LimitKind::kForce:
    case LimitKind::kTorque: return RobotError::kForceControlSafetyViolation;
    case LimitKind::kJointRange: return RobotError::kJointPositionLimitsViolation;
    case LimitKind::kJointSpeed:
    case LimitKind::kNoStop: break;
  }
  return RobotError::kJointVelocityViolation;
}

std::int8_t AxisOf(const BrokenLimit& breach) noexcept {
  switch (breach.kind) {
    case LimitKind::kSpeed: return 0;
    case LimitKind::kTurn: return 1;
    case LimitKind::kForce:
    case LimitKind::kTorque: return -1;
    default: return breach.axis;
  }
}

}  // namespace

Violations OnboardController::Guarded(const std::optional<BrokenLimit>& breach) noexcept {
  Violations found;
  if (!breach) return found;
  guard_breach_ = breach;
  found.Add(
      {ErrorOf(breach->kind), AxisOf(*breach), breach->value, breach->bound, message_id_ + 1});
  return found;
}

Violations OnboardController::CheckStopOf(const MotionGenerator& next) noexcept {
  if (modes_.controller == ControllerMode::kExternalController) return {};
  return Guarded(guard_->Check(next.joints()));
}

Violations OnboardController::CheckGuardMeasured(const JointSensors& sensors) noexcept {
  const Violations found = Guarded(
      CheckForces(guard_->limits(), sensing_.O_F_ext_hat_K(), sensing_.tau_ext_hat_filtered()));
  if (!found.empty() || !external_torque_acts_) return found;
  JointReference measured = JointReference::Rest(sensors.q).AfterVelocity(sensors.dq);
  measured.ddq_d = {};  // as at the beginning of an abort's stop
  return Guarded(guard_->Check(measured));
}

Violations OnboardController::HoldGuarded() noexcept {
  MotionGenerator next = generator_;
  Violations found = next.Hold(message_id_ + 1);
  if (found.empty()) found = CheckStopOf(next);
  if (found.empty()) generator_ = next;
  return found;
}

}  // namespace twin::onboard

#include <algorithm>
#include <limits>

#include "onboard/bounds.h"
#include "twin/core/error_catalogue.h"
#include "twin/core/robot_state.h"
#include "twin/onboard/limit_monitor.h"
#include "twin/onboard/onboard_controller.h"

// A cycle of OnboardController: automatic mode changes, the reference, the torque.

namespace twin::onboard {
const JointDrive& OnboardController::Cycle(const RobotCommand* command,
                                           const JointSensors& measured) noexcept {
  fate_ = record::CommandFate::kNone;
  violations_ = Violations();
  const JointSensors& sensors = Sound(measured);
  if (is_new_) sensing_.Reset(sensors, setup_);  // no sensor values yet
  AdvanceMode(sensors);
  AdvanceReference(command, sensors);
  DriveJoints(sensors);
  return drive_;
}

void OnboardController::AdvanceMode(const JointSensors& sensors) noexcept {
  if (robot_mode_ == RobotMode::kAutomaticErrorRecovery && --recovery_cycles_left_ == 0) {
    robot_mode_ = RobotMode::kIdle;
  }
  if (begins_guiding_) {
    begins_guiding_ = false;
    guiding_.Begin(sensors.q, setup_);
  }
  const bool is_led = robot_mode_ == RobotMode::kGuiding;
  const bool is_braked = brakes_closed_ || (halted_ && !is_led) ||
                         (robot_mode_ == RobotMode::kUserStopped && generator_.AtRest());
  if (drive_.brakes && !is_braked) generator_.TakeOver(sensors.q, JointVector{});
  if (is_led) generator_.TakeOver(sensors.q, sensors.dq);
  drive_.brakes = is_braked;
}

void OnboardController::AdvanceReference(const RobotCommand* command,
                                         const JointSensors& sensors) noexcept {
  WatchRest(sensors.dq);
  if (!violations_.empty()) return;  // halted
  const bool is_watched = phase_ != Phase::kNone || robot_mode_ == RobotMode::kIdle;
  if (is_watched) violations_ = sensing_.Collisions(message_id_ + 1);
  if (phase_ != Phase::kNone) {
    violations_.Add(
        sensing_.CheckMeasured(tau_J_d_, message_id_ + 1, IsCartesian(modes_.generator)));
    if (guard_) violations_.Add(CheckGuardMeasured(sensors));
  }
  if (!violations_.empty()) {
    Abort(sensors);
    return;
  }
  switch (phase_) {
    case Phase::kNone:
      TakeOver(sensors);  // after a user stop
      if (robot_mode_ != RobotMode::kGuiding) generator_.Brake();
      break;
    case Phase::kStarting: AwaitFirstCommand(command); break;
    case Phase::kRunning: command != nullptr ? Take(*command, false) : Hold(); break;
    case Phase::kFinishing: Finish(sensors); break;
    case Phase::kPreempting: Preempt(sensors); break;
  }
  if (!violations_.empty()) Abort(sensors);
}

void OnboardController::AwaitFirstCommand(const RobotCommand* command) noexcept {
  generator_.Rest();
  // In the first cycle that shows the modes, a command can only answer a state from before the
  // motion: it belongs to another one.
  if (command != nullptr && cycles_waited_ > 0) {
    Take(*command, true);
    return;
  }
  ++cycles_waited_;
  if (!modes_.asynchronous && cycles_waited_ >= config_.first_command_timeout_cycles) {
    violations_.Add({RobotError::kCommunicationConstraintsViolation, kNoFirstCommandAxis,
                     static_cast<double>(cycles_waited_),
                     static_cast<double>(config_.first_command_timeout_cycles), message_id_ + 1});
  }
}

void OnboardController::Take(const RobotCommand& command, bool is_first) noexcept {
  const bool is_external = modes_.controller == ControllerMode::kExternalController;
  JointVector tau_J_d = command.tau_J_d;
  Violations torque;
  if (is_external) {
    if (torque_filter_.is_on()) tau_J_d = torque_filter_.Filter(tau_J_d, tau_J_d_);
    torque = CheckTorqueRate(tau_J_d, tau_J_d_, config_.limits, message_id_ + 1);
  }
  violations_ = TryStep(command, is_first, torque);
  fate_ = record::CommandFate::kServed;
  losses_.CountServed();
  if (!violations_.empty()) return;
  if (is_external) {
    tau_J_d_ = tau_J_d;
    external_torque_acts_ = true;
  }
  if (is_first) ++motions_begun_;
  phase_ = command.motion_generation_finished ? Phase::kFinishing : Phase::kRunning;
}

Violations OnboardController::TryStep(const RobotCommand& command, bool is_first,
                                      const Violations& torque) noexcept {
  const bool finishes = command.motion_generation_finished;
  if (torque.empty() && !finishes && !guard_)
    return generator_.Take(command, is_first, message_id_ + 1);
  // Tries the step on a copy, since a later check may reject it.
  MotionGenerator next = generator_;
  Violations found = next.Take(command, is_first, message_id_ + 1);
  if (found.empty() && finishes && !modes_.asynchronous) {
    found = next.CheckStandingStill(message_id_ + 1);
  }
  if (found.empty() && guard_) found = CheckStopOf(next);
  found.Add(torque);
  if (found.empty()) generator_ = next;
  return found;
}

void OnboardController::Hold() noexcept {
  if (modes_.asynchronous) {
    violations_ = guard_ ? HoldGuarded() : generator_.Hold(message_id_ + 1);
    return;
  }
  fate_ = record::CommandFate::kHeld;
  losses_.CountLost();
  if (losses_.lost_in_row() >= config_.abort_after_lost) {
    violations_.Add({RobotError::kCommunicationConstraintsViolation, -1,
                     static_cast<double>(losses_.lost_in_row()),
                     static_cast<double>(config_.abort_after_lost), message_id_ + 1});
    return;
  }
  violations_ = guard_ ? HoldGuarded() : generator_.Hold(message_id_ + 1);
}

void OnboardController::Finish(const JointSensors& sensors) noexcept {
  if (modes_.controller == ControllerMode::kExternalController) {
    TakeOver(sensors);
    generator_.Brake();
  } else if (modes_.asynchronous) {
    generator_.Brake();
  } else {
    generator_.StandStill();
  }
  if (generator_.AtRest()) EndMotion(MoveStatus::kSuccess, RobotMode::kIdle);
}

void OnboardController::Preempt(const JointSensors& sensors) noexcept {
  TakeOver(sensors);
  MotionGenerator next = generator_;
  next.Brake();
  if (modes_.controller != ControllerMode::kExternalController) {
    const RobotError error =
        IsCartesian(modes_.generator) ? kInverseKinematicsErrors.position : StepErrors{}.position;
    internal::CheckJointRanges(error, next.joints().q_d, config_.limits.q_min, config_.limits.q_max,
                               message_id_ + 1, violations_);
    if (!violations_.empty()) return;
  }
  generator_ = next;
  if (generator_.AtRest()) EndMotion(MoveStatus::kPreempted, RobotMode::kIdle);
}

void OnboardController::Abort(const JointSensors& sensors) noexcept {
  for (const Violation& violation : violations_.items()) {
    errors_.set(static_cast<std::size_t>(violation.error));
  }
  EndByError(RobotMode::kReflex);
  TakeOver(sensors);
  generator_.Brake();
}

void OnboardController::EndByError(RobotMode mode) noexcept {
  if (phase_ != Phase::kNone) reflex_reason_ = errors_;
  EndMotion(MoveStatus::kReflexAborted, mode);
}

void OnboardController::TakeOver(const JointSensors& sensors) noexcept {
  if (!external_torque_acts_) return;
  external_torque_acts_ = false;
  cartesian_impedance_acts_ = false;
  generator_.TakeOver(sensors.q, sensors.dq);
}

void OnboardController::WatchRest(const JointVector& dq) noexcept {
  const std::uint64_t cycle = message_id_ + 1;
  const bool is_held =
      phase_ == Phase::kNone && robot_mode_ != RobotMode::kGuiding && !drive_.brakes;
  if (!is_held) {
    rest_.Restart(cycle);
    return;
  }
  rest_.Observe(cycle, dq);
  if (rest_.Restless() < kRestTimeout) return;
  const std::size_t joint = FastestJoint(dq);
  Halt(static_cast<std::int8_t>(joint), dq[joint], kRestSpeed);
}

void OnboardController::Halt(std::int8_t axis, double value, double limit) noexcept {
  if (!halted_) {
    violations_.Add({RobotError::kInstabilityDetected, axis, value, limit, message_id_ + 1});
  }
  halted_ = true;
  rest_.Restart(message_id_ + 1);
  errors_.set(static_cast<std::size_t>(RobotError::kInstabilityDetected));
  const bool is_held_up =
      robot_mode_ == RobotMode::kOther || robot_mode_ == RobotMode::kUserStopped;
  EndByError(is_held_up ? robot_mode_ : RobotMode::kReflex);
  external_torque_acts_ = false;
  cartesian_impedance_acts_ = false;
  generator_.TakeOver(sound_.q, JointVector{});
  tau_J_d_ = JointVector{};
  drive_ = {.tau = {}, .q_d = sound_.q, .dq_d = {}, .ddq_d = {}, .brakes = true};
}

void OnboardController::HaltOnNoNumber() noexcept {
  Halt(kNoNumberAxis, std::numeric_limits<double>::quiet_NaN(), 0);
}

const JointSensors& OnboardController::Sound(const JointSensors& measured) noexcept {
  if (IsFinite(measured)) return measured;
  HaltOnNoNumber();
  return sound_;
}

ImpedanceTorque OnboardController::ControlTorque(const JointSensors& sensors) noexcept {
  if (drive_.brakes) return {};
  const MeasuredArm& measured = sensing_.arm();
  if (robot_mode_ == RobotMode::kGuiding)
    return guiding_.Torque(sensors, measured, config_.arm, setup_);
  if (external_torque_acts_) {
    ImpedanceTorque torque{tau_J_d_, measured.g};
    for (std::size_t i = 0; i < kJoints; ++i) torque.tau[i] += tau_J_d_[i];
    return torque;
  }
  if (cartesian_impedance_acts_) {
    return cartesian_impedance_.Torque(generator_.joints(), generator_.O_T_EE_d(), sensors,
                                       measured, config_.arm, setup_);
  }
  return joint_impedance_.Torque(generator_.joints(), sensors, measured, config_.arm, setup_);
}

void OnboardController::DriveJoints(const JointSensors& sensors) noexcept {
  ImpedanceTorque torque = ControlTorque(sensors);
  if (!IsFinite(torque.tau)) {
    HaltOnNoNumber();
    return;
  }
  tau_J_d_ = torque.tau_J_d;
  if (!drive_.brakes) friction_.AddTo(torque.tau, sensors.dq);
  for (std::size_t i = 0; i < kJoints; ++i) {
    drive_.tau[i] =
        std::clamp(torque.tau[i], -config_.limits.tau_max[i], config_.limits.tau_max[i]);
  }
  const JointReference& reference = generator_.joints();
  drive_.q_d = reference.q_d;
  drive_.dq_d = reference.dq_d;
  drive_.ddq_d = reference.ddq_d;
}

}  // namespace twin::onboard

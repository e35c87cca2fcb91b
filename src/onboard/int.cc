#include "twin/onboard/int.h"

#include <algorithm>
#include <cmath>

#include "twin/onboard/stop_profile.h"

namespace twin::onboard {
namespace {

/// How long automatic error recovery shows its mode. The robot's own duration is not public.
constexpr std::uint32_t kRecoveryCycles = 100;

IntConfig Validated(const IntConfig& config) {
  config.Validate();
  return config;
}

JointVector TorqueRange(const IntConfig& config) noexcept {
  if (config.tau_J_range) return *config.tau_J_range;
  JointVector range = config.limits.tau_max;
  for (double& tau : range) tau *= 1.2;
  return range;
}

bool Offers(const MotionModes& modes) noexcept {
  return (modes.controller == ControllerMode::kJointImpedance ||
          modes.controller == ControllerMode::kExternalController) &&
         (modes.generator == MotionGeneratorMode::kJointPosition ||
          modes.generator == MotionGeneratorMode::kJointVelocity);
}

}  // namespace

Int::Int(const IntConfig& config, const JointVector& q0)
    : config_(Validated(config)),
      arm_(model::ArmModel::Panda()),
      impedance_(config.K_theta, config.damping_ratio, config.rotor_inertia),
      friction_(config.friction_compensation),
      tau_J_range_(TorqueRange(config)),
      F_T_EE_(config.F_T_NE),
      reference_(JointReference::Rest(q0)) {}

MoveStatus Int::Move(const MotionModes& modes) noexcept {
  if (!Offers(modes)) return MoveStatus::kInvalidArgumentRejected;
  if (robot_mode_ != RobotMode::kIdle || !reference_.AtRest()) {
    return MoveStatus::kCommandNotPossibleRejected;
  }
  robot_mode_ = RobotMode::kMove;
  phase_ = Phase::kStarting;
  modes_ = modes;
  cycles_waited_ = 0;
  losses_.Reset();
  reflex_reason_.reset();
  last_end_ = MoveStatus::kMotionStarted;
  return MoveStatus::kMotionStarted;
}

void Int::StopMove() noexcept {
  if (phase_ != Phase::kNone) phase_ = Phase::kPreempting;
}

RecoveryStatus Int::AutomaticErrorRecovery() noexcept {
  if (robot_mode_ == RobotMode::kReflex) {
    if (!reference_.AtRest()) return RecoveryStatus::kCommandNotPossibleRejected;
    errors_.reset();
    robot_mode_ = RobotMode::kAutomaticErrorRecovery;
    recovery_cycles_left_ = kRecoveryCycles;
  }
  return RecoveryStatus::kSuccess;
}

SetterStatus Int::SetJointImpedance(const JointVector& K_theta) noexcept {
  if (robot_mode_ != RobotMode::kIdle) return SetterStatus::kCommandNotPossibleRejected;
  const auto valid = [](double k) { return k >= 0 && k <= kMaxJointStiffness; };
  if (!std::all_of(K_theta.begin(), K_theta.end(), valid)) {
    return SetterStatus::kInvalidArgumentRejected;
  }
  impedance_ = JointImpedance(K_theta, config_.damping_ratio, config_.rotor_inertia);
  return SetterStatus::kSuccess;
}

const JointDrive& Int::Cycle(const RobotCommand* command, const JointSensors& sensors) noexcept {
  fate_ = rt::CommandFate::kNone;
  violations_ = Violations();
  if (robot_mode_ == RobotMode::kAutomaticErrorRecovery && --recovery_cycles_left_ == 0) {
    robot_mode_ = RobotMode::kIdle;
  }
  AdvanceReference(command, sensors);
  DriveJoints(sensors);
  return drive_;
}

void Int::DriveJoints(const JointSensors& sensors) noexcept {
  JointVector tau{};
  if (external_torque_acts_) {
    const JointVector g = arm_.Gravity(sensors.q, config_.end_effector);
    for (std::size_t i = 0; i < kJoints; ++i) tau[i] = tau_J_d_[i] + g[i];
  } else {
    const ImpedanceTorque torque =
        impedance_.Torque(reference_, sensors, arm_, config_.end_effector);
    tau_J_d_ = torque.tau_J_d;
    tau = torque.tau;
  }
  friction_.AddTo(tau, sensors.dq);
  for (std::size_t i = 0; i < kJoints; ++i) {
    drive_.tau[i] = std::clamp(tau[i], -config_.limits.tau_max[i], config_.limits.tau_max[i]);
  }
  drive_.q_d = reference_.q_d;
  drive_.dq_d = reference_.dq_d;
  drive_.ddq_d = reference_.ddq_d;
}

void Int::AdvanceReference(const RobotCommand* command, const JointSensors& sensors) noexcept {
  if (phase_ != Phase::kNone) {
    violations_ = CheckTorqueRange(sensors.tau_J, tau_J_range_, message_id_ + 1);
    if (!violations_.empty()) {
      Abort(sensors);
      return;
    }
  }
  switch (phase_) {
    case Phase::kNone: reference_ = StopStep(reference_, config_.limits); break;
    case Phase::kStarting: AwaitFirstCommand(command); break;
    case Phase::kRunning: command != nullptr ? Take(*command) : Hold(); break;
    case Phase::kFinishing: Finish(sensors); break;
    case Phase::kPreempting:
      TakeOver(sensors);
      reference_ = StopStep(reference_, config_.limits);
      if (reference_.AtRest()) EndMotion(MoveStatus::kPreempted);
      break;
  }
  if (!violations_.empty()) Abort(sensors);
}

void Int::AwaitFirstCommand(const RobotCommand* command) noexcept {
  reference_ = JointReference::Rest(reference_.q_d);
  if (command == nullptr) {
    if (++cycles_waited_ >= config_.first_command_timeout_cycles) {
      violations_.Add({RobotError::kCommunicationConstraintsViolation, -1,
                       static_cast<double>(cycles_waited_),
                       static_cast<double>(config_.first_command_timeout_cycles), message_id_ + 1});
    }
    return;
  }
  if (modes_.generator == MotionGeneratorMode::kJointPosition) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double distance = std::abs(command->q_c[i] - reference_.q_d[i]);
      if (distance <= config_.start_pose_tolerance_rad) continue;
      violations_.Add({RobotError::kJointPositionMotionGeneratorStartPoseInvalid,
                       static_cast<std::int8_t>(i), distance, config_.start_pose_tolerance_rad,
                       message_id_ + 1});
      return;
    }
  }
  phase_ = Phase::kRunning;
  Take(*command);
}

void Int::Take(const RobotCommand& command) noexcept {
  fate_ = rt::CommandFate::kServed;
  losses_.CountServed();
  const bool is_external = modes_.controller == ControllerMode::kExternalController;
  const bool finishes = command.motion_generation_finished;
  const JointReference next = Commanded(command);
  violations_ = CheckStep(next, config_.limits, message_id_ + 1);
  if (violations_.empty() && finishes) violations_ = CheckStandingStill(next);
  if (is_external) {
    violations_.Add(CheckTorqueRate(command.tau_J_d, tau_J_d_, config_.limits, message_id_ + 1));
  }
  if (!violations_.empty()) return;
  reference_ = next;
  if (is_external) {
    tau_J_d_ = command.tau_J_d;
    external_torque_acts_ = true;
  }
  if (finishes) phase_ = Phase::kFinishing;
}

void Int::Hold() noexcept {
  fate_ = rt::CommandFate::kHeld;
  losses_.CountLost();
  if (losses_.lost_in_row() >= config_.abort_after_lost) {
    violations_.Add({RobotError::kCommunicationConstraintsViolation, -1,
                     static_cast<double>(losses_.lost_in_row()),
                     static_cast<double>(config_.abort_after_lost), message_id_ + 1});
    return;
  }
  const JointReference next = reference_.AfterLoss();
  violations_ = CheckStep(next, config_.limits, message_id_ + 1);
  if (violations_.empty()) reference_ = next;
}

JointReference Int::Commanded(const RobotCommand& command) const noexcept {
  return modes_.generator == MotionGeneratorMode::kJointPosition
             ? reference_.AfterPosition(command.q_c)
             : reference_.AfterVelocity(command.dq_c);
}

Violations Int::CheckStandingStill(const JointReference& last) const noexcept {
  const JointReference first = last.AfterPosition(last.q_d);
  const Violations found = CheckStep(first, config_.limits, message_id_ + 1);
  if (!found.empty()) return found;
  return CheckStep(first.AfterPosition(first.q_d), config_.limits, message_id_ + 1);
}

void Int::Finish(const JointSensors& sensors) noexcept {
  if (modes_.controller == ControllerMode::kExternalController) {
    TakeOver(sensors);
    reference_ = StopStep(reference_, config_.limits);
  } else {
    reference_ = reference_.AfterPosition(reference_.q_d);
  }
  if (reference_.AtRest()) EndMotion(MoveStatus::kSuccess);
}

void Int::Abort(const JointSensors& sensors) noexcept {
  for (const Violation& violation : violations_.items()) {
    errors_.set(static_cast<std::size_t>(violation.error));
  }
  reflex_reason_ = errors_;
  EndMotion(MoveStatus::kReflexAborted);
  robot_mode_ = RobotMode::kReflex;
  TakeOver(sensors);
  reference_ = StopStep(reference_, config_.limits);
}

void Int::EndMotion(MoveStatus end) noexcept {
  phase_ = Phase::kNone;
  last_end_ = end;
  robot_mode_ = RobotMode::kIdle;
}

void Int::TakeOver(const JointSensors& sensors) noexcept {
  if (!external_torque_acts_) return;
  external_torque_acts_ = false;
  reference_ = JointReference::Rest(sensors.q);
  reference_.dq_d = sensors.dq;
}

}  // namespace twin::onboard

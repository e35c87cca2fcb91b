#include "twin/onboard/int.h"

#include <algorithm>
#include <cmath>

#include "twin/core/time.h"
#include "twin/model/transform.h"
#include "twin/onboard/stop_profile.h"

namespace twin::onboard {
namespace {

/// How long automatic error recovery shows its mode. The robot's own duration is not public.
constexpr std::uint32_t kRecoveryCycles = 100;

IntConfig Validated(const IntConfig& config) {
  config.Validate();
  return config;
}

bool Offers(const MotionModes& modes) noexcept {
  return modes.controller == ControllerMode::kJointImpedance &&
         (modes.generator == MotionGeneratorMode::kJointPosition ||
          modes.generator == MotionGeneratorMode::kJointVelocity);
}

}  // namespace

Int::Int(const IntConfig& config, const JointVector& q0)
    : config_(Validated(config)),
      arm_(model::ArmModel::Panda()),
      impedance_(config.K_theta, config.damping_ratio, config.rotor_inertia),
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
  AdvanceReference(command);

  const ImpedanceTorque torque = impedance_.Torque(reference_, sensors, arm_, config_.end_effector);
  tau_J_d_ = torque.tau_J_d;
  for (std::size_t i = 0; i < kJoints; ++i) {
    drive_.tau[i] =
        std::clamp(torque.tau[i], -config_.limits.tau_max[i], config_.limits.tau_max[i]);
  }
  drive_.q_d = reference_.q_d;
  drive_.dq_d = reference_.dq_d;
  drive_.ddq_d = reference_.ddq_d;
  return drive_;
}

void Int::AdvanceReference(const RobotCommand* command) noexcept {
  switch (phase_) {
    case Phase::kNone: reference_ = StopStep(reference_, config_.limits); break;
    case Phase::kStarting: AwaitFirstCommand(command); break;
    case Phase::kRunning: TakeOrHold(command); break;
    case Phase::kFinishing:
      reference_ = reference_.AfterPosition(reference_.q_d);
      if (reference_.AtRest()) EndMotion(MoveStatus::kSuccess);
      break;
    case Phase::kPreempting:
      reference_ = StopStep(reference_, config_.limits);
      if (reference_.AtRest()) EndMotion(MoveStatus::kPreempted);
      break;
  }
}

void Int::AwaitFirstCommand(const RobotCommand* command) noexcept {
  reference_ = JointReference::Rest(reference_.q_d);
  if (command == nullptr) {
    if (++cycles_waited_ >= config_.first_command_timeout_cycles) {
      violations_.Add({RobotError::kCommunicationConstraintsViolation, -1,
                       static_cast<double>(cycles_waited_),
                       static_cast<double>(config_.first_command_timeout_cycles), message_id_ + 1});
      Abort();
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
      Abort();
      return;
    }
  }
  phase_ = Phase::kRunning;
  TakeOrHold(command);
}

void Int::TakeOrHold(const RobotCommand* command) noexcept {
  if (command != nullptr) {
    fate_ = rt::CommandFate::kServed;
    losses_.CountServed();
    const bool finishes = command->motion_generation_finished;
    if (Accept(Commanded(*command), finishes) && finishes) phase_ = Phase::kFinishing;
    return;
  }
  fate_ = rt::CommandFate::kHeld;
  losses_.CountLost();
  if (losses_.lost_in_row() >= config_.abort_after_lost) {
    violations_.Add({RobotError::kCommunicationConstraintsViolation, -1,
                     static_cast<double>(losses_.lost_in_row()),
                     static_cast<double>(config_.abort_after_lost), message_id_ + 1});
    Abort();
    return;
  }
  static_cast<void>(Accept(reference_.AfterLoss(), false));
}

JointReference Int::Commanded(const RobotCommand& command) const noexcept {
  return modes_.generator == MotionGeneratorMode::kJointPosition
             ? reference_.AfterPosition(command.q_c)
             : reference_.AfterVelocity(command.dq_c);
}

bool Int::Accept(const JointReference& next, bool finishes) noexcept {
  violations_ = CheckStep(next, config_.limits, message_id_ + 1);
  if (violations_.empty() && finishes) violations_ = CheckStandingStill(next);
  if (!violations_.empty()) {
    Abort();
    return false;
  }
  reference_ = next;
  return true;
}

Violations Int::CheckStandingStill(const JointReference& last) const noexcept {
  const JointReference first = last.AfterPosition(last.q_d);
  const Violations found = CheckStep(first, config_.limits, message_id_ + 1);
  if (!found.empty()) return found;
  return CheckStep(first.AfterPosition(first.q_d), config_.limits, message_id_ + 1);
}

void Int::Abort() noexcept {
  for (const Violation& violation : violations_.items()) {
    errors_.set(static_cast<std::size_t>(violation.error));
  }
  reflex_reason_ = errors_;
  EndMotion(MoveStatus::kReflexAborted);
  robot_mode_ = RobotMode::kReflex;
  reference_ = StopStep(reference_, config_.limits);
}

void Int::EndMotion(MoveStatus end) noexcept {
  phase_ = Phase::kNone;
  last_end_ = end;
  robot_mode_ = RobotMode::kIdle;
}

void Int::FillState(const JointSensors& sensors, RobotState& state) noexcept {
  const bool moving = phase_ != Phase::kNone;
  state.message_id = ++message_id_;
  state.q = sensors.q;
  state.dq = sensors.dq;
  state.tau_J = sensors.tau_J;
  state.theta = sensors.theta;
  state.dtheta = sensors.dtheta;
  for (std::size_t i = 0; i < kJoints; ++i) {
    state.dtau_J[i] = message_id_ > 1 ? (sensors.tau_J[i] - last_tau_J_[i]) / kCycleSeconds : 0;
  }
  last_tau_J_ = sensors.tau_J;
  state.tau_J_d = tau_J_d_;
  state.O_T_EE = arm_.Pose(model::Frame::kEndEffector, sensors.q, F_T_EE_);
  state.elbow = model::ElbowOf(sensors.q);
  FillDesired(state);

  state.robot_mode = robot_mode_;
  state.motion_generator_mode = moving ? modes_.generator : MotionGeneratorMode::kIdle;
  state.controller_mode = moving ? modes_.controller : ControllerMode::kOther;
  state.errors = errors_;
  state.reflex_reason = reflex_reason_;
  state.control_command_success_rate = moving ? losses_.success_rate() : 0;
}

void Int::FillDesired(RobotState& state) const noexcept {
  state.q_d = reference_.q_d;
  state.dq_d = reference_.dq_d;
  state.ddq_d = reference_.ddq_d;
  const model::Configuration q_d(reference_.q_d);
  state.O_T_EE_d = arm_.Pose(model::Frame::kEndEffector, q_d, F_T_EE_);
  state.O_dP_EE_d = arm_.Twist(model::Frame::kEndEffector, q_d, reference_.dq_d, F_T_EE_);
  state.O_T_EE_c = state.O_T_EE_d;
  state.O_dP_EE_c = state.O_dP_EE_d;
  state.elbow_d = model::ElbowOf(reference_.q_d);
  state.elbow_c = state.elbow_d;
  state.delbow_c = {reference_.dq_d[2], 0};
  state.ddelbow_c = {reference_.ddq_d[2], 0};
  state.F_T_EE = F_T_EE_;
  state.F_T_NE = config_.F_T_NE;
  state.m_ee = config_.end_effector.m;
  state.F_x_Cee = config_.end_effector.F_x_C;
  state.I_ee = config_.end_effector.I;
}

}  // namespace twin::onboard

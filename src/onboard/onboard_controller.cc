#include "twin/onboard/onboard_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "twin/onboard/arm_setup.h"

// Requests to OnboardController: motions, settings, recovery, buttons.

namespace twin::onboard {
namespace {

/// How long automatic error recovery shows its mode. The robot's own duration is not public.
constexpr std::uint32_t kRecoveryCycles = 100;

OnboardConfig Validated(const OnboardConfig& config) {
  config.Validate();
  return config;
}

GeneratorLimits LimitsOf(const OnboardConfig& config) {
  return {.joints = config.limits,
          .cartesian = config.cartesian,
          .start_q_rad = config.start_pose_tolerance_rad,
          .start_translation_m = config.start_translation_tolerance_m,
          .start_rotation_rad = config.start_rotation_tolerance_rad,
          .start_elbow_rad = config.start_elbow_tolerance_rad,
          .own_joints = config.own_limits};
}

SensingConfig SensingOf(const OnboardConfig& config) {
  SensingConfig sensing = config.sensing;
  sensing.joints = config.limits;
  sensing.cartesian = config.cartesian;
  sensing.arm = config.arm;
  return sensing;
}

/// The stop that INT executes heeds no joint's range, and its guard no more than the stop.
std::optional<StopProof> GuardOf(const OnboardConfig& config, const Transform& F_T_EE) {
  if (config.guard.empty()) return {};
  JointLimits joints = config.own_limits.value_or(config.limits);
  joints.q_min.fill(-std::numeric_limits<double>::infinity());
  joints.q_max.fill(std::numeric_limits<double>::infinity());
  return StopProof(joints, config.guard, {.F_T_EE = F_T_EE, .with_hand = config.guard_has_hand});
}

bool IsCombination(const MotionModes& modes) noexcept {
  if (modes.controller > ControllerMode::kExternalController) return false;
  const bool is_external = modes.controller == ControllerMode::kExternalController;
  if (modes.generator == MotionGeneratorMode::kNone) return is_external && !modes.asynchronous;
  if (modes.asynchronous) {
    const auto moves = [](double dq) { return std::isfinite(dq) && dq > 0; };
    return !is_external && modes.generator == MotionGeneratorMode::kJointPosition &&
           std::ranges::all_of(*modes.asynchronous, moves);
  }
  return modes.generator >= MotionGeneratorMode::kJointPosition &&
         modes.generator <= MotionGeneratorMode::kCartesianVelocity;
}

}  // namespace

OnboardController::OnboardController(const OnboardConfig& config, const JointVector& q0)
    : config_(Validated(config)),
      setup_(SetupOf(config)),
      generator_(LimitsOf(config), q0),
      sensing_(SensingOf(config)),
      joint_impedance_(config.joint_impedance.K_theta, config.damping_ratio, config.rotor_inertia),
      cartesian_impedance_(config.cartesian_impedance.K_x, config.damping_ratio,
                           config.rotor_inertia),
      guiding_(config.rotor_inertia),
      friction_(config.friction_compensation),
      torque_filter_(config.filters.controller_hz),
      guard_(GuardOf(config, setup_.F_T_EE)) {
  generator_.SetEndEffector(setup_.F_T_EE);
  generator_.SetFilters(config.filters);
  sensing_.SetCollisionBehavior(config.collision_behavior);
  guiding_.SetMode(config.guiding_mode);
  sound_.q = q0;
}

void OnboardController::Restart(const OnboardConfig& config, const JointVector& q0) {
  OnboardController fresh(config, q0);
  fresh.message_id_ = message_id_;
  fresh.motions_begun_ = motions_begun_;
  *this = fresh;
}

OnboardController& OnboardController::operator=(const OnboardController& other) noexcept {
  if (this == &other) return *this;
  std::destroy_at(this);
  return *std::construct_at(this, other);
}

bool OnboardController::Grants(Request request) const noexcept {
  switch (VerdictOn(robot_mode_, request)) {
    case Verdict::kGranted: return true;
    case Verdict::kGrantedAtRest: return generator_.AtRest();
    case Verdict::kNothingToDo:
    case Verdict::kNothingUnlessError:
    case Verdict::kRefused: break;
  }
  return false;
}

MoveStatus OnboardController::Move(const MotionModes& modes) noexcept {
  if (!IsCombination(modes)) return MoveStatus::kInvalidArgumentRejected;
  if (!Grants(Request::kMove)) return MoveStatus::kCommandNotPossibleRejected;
  if (IsCartesian(modes.generator) && generator_.IsSingular()) {
    return MoveStatus::kStartAtSingularPoseRejected;
  }
  robot_mode_ = RobotMode::kMove;
  phase_ = Phase::kStarting;
  modes_ = modes;
  if (modes.controller != ControllerMode::kExternalController) {
    cartesian_impedance_acts_ = modes.controller == ControllerMode::kCartesianImpedance;
  }
  motion_id_ = message_id_ + 1;
  cycles_waited_ = 0;
  losses_.Reset();
  reflex_reason_.reset();
  last_end_ = MoveStatus::kMotionStarted;
  guard_breach_.reset();
  generator_.Start(modes);
  return MoveStatus::kMotionStarted;
}

void OnboardController::StopMove() noexcept {
  if (Grants(Request::kStopMove)) phase_ = Phase::kPreempting;
}

RecoveryStatus OnboardController::AutomaticErrorRecovery() noexcept {
  const Verdict verdict = VerdictOn(robot_mode_, Request::kAutomaticErrorRecovery);
  const bool has_nothing_to_do = verdict == Verdict::kNothingToDo ||
                                 (verdict == Verdict::kNothingUnlessError && errors_.none());
  if (has_nothing_to_do) return RecoveryStatus::kSuccess;
  if (!Grants(Request::kAutomaticErrorRecovery)) {
    return RecoveryStatus::kCommandNotPossibleRejected;
  }
  if (sensing_.NeedsManualRecovery()) return RecoveryStatus::kManualErrorRecoveryRequiredRejected;
  errors_.reset();
  halted_ = false;
  sensing_.ClearCollisions();
  robot_mode_ = RobotMode::kAutomaticErrorRecovery;
  recovery_cycles_left_ = kRecoveryCycles;
  return RecoveryStatus::kSuccess;
}

SetterStatus OnboardController::Configure(const Setting& setting) noexcept {
  if (!Grants(Request::kSet)) return SetterStatus::kCommandNotPossibleRejected;
  if (FindBadValue(setting)) return SetterStatus::kInvalidArgumentRejected;
  std::visit([this](const auto& one) { Set(one); }, setting);
  return SetterStatus::kSuccess;
}

void OnboardController::Set(const setting::JointImpedance& impedance) noexcept {
  config_.joint_impedance = impedance;
  joint_impedance_ =
      JointImpedance(impedance.K_theta, config_.damping_ratio, config_.rotor_inertia);
}

void OnboardController::Set(const setting::CartesianImpedance& impedance) noexcept {
  config_.cartesian_impedance = impedance;
  cartesian_impedance_ =
      CartesianImpedance(impedance.K_x, config_.damping_ratio, config_.rotor_inertia);
}

void OnboardController::Set(const setting::CollisionBehavior& behavior) noexcept {
  sensing_.SetCollisionBehavior(behavior);
}

void OnboardController::Set(const setting::GuidingMode& mode) noexcept {
  guiding_.SetMode(mode);
}

void OnboardController::ChangeSetup() noexcept {
  setup_ = SetupOf(config_);
  sensing_.Measure(setup_);
}

void OnboardController::Set(const setting::StiffnessFrame& frame) noexcept {
  config_.stiffness_frame = frame;
  ChangeSetup();
}

void OnboardController::Set(const setting::EndEffectorFrame& frame) noexcept {
  config_.end_effector_frame = frame;
  ChangeSetup();
  generator_.SetEndEffector(setup_.F_T_EE);
  if (guard_) guard_->SetEndEffector(setup_.F_T_EE);
}

void OnboardController::Set(const setting::Load& load) noexcept {
  config_.load = load;
  ChangeSetup();
  payload_changed_ = true;
}

void OnboardController::Set(const setting::Filters& filters) noexcept {
  generator_.SetFilters(filters);
  torque_filter_ = reference::LowPass(filters.controller_hz);
}

bool OnboardController::Operate(PanelAction action) noexcept {
  const Verdict verdict = VerdictOn(robot_mode_, RequestOf(action));
  if (verdict == Verdict::kNothingToDo) return true;
  if (!Grants(RequestOf(action))) return false;
  switch (action) {
    case PanelAction::kPressUserStop:
      EndMotion(MoveStatus::kEmergencyAborted, RobotMode::kUserStopped);
      recovery_cycles_left_ = 0;
      break;
    case PanelAction::kCloseBrakes:
      brakes_closed_ = true;
      robot_mode_ = RobotMode::kOther;
      break;
    case PanelAction::kOpenBrakes:
      brakes_closed_ = false;
      LeaveToRest();
      break;
    case PanelAction::kPressGuidingButton:
      robot_mode_ = RobotMode::kGuiding;
      begins_guiding_ = true;
      break;
    case PanelAction::kReleaseUserStop:
    case PanelAction::kReleaseGuidingButton: LeaveToRest(); break;
  }
  return true;
}

void OnboardController::LeaveToRest() noexcept {
  if (errors_.none()) sensing_.ClearCollisions();  // people leading the arm cause no collisions
  if (brakes_closed_) {
    robot_mode_ = RobotMode::kOther;
  } else {
    robot_mode_ = errors_.any() ? RobotMode::kReflex : RobotMode::kIdle;
  }
}

void OnboardController::EndMotion(MoveStatus end, RobotMode mode) noexcept {
  if (phase_ != Phase::kNone) last_end_ = end;
  phase_ = Phase::kNone;
  robot_mode_ = mode;
}

}  // namespace twin::onboard

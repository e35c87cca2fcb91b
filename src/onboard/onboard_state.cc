#include <algorithm>
#include <cmath>

#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/onboard/onboard_controller.h"

// Reports of OnboardController: the robot state of a cycle.

namespace twin::onboard {
namespace {

/// Acceleration of the reference, rad/s^2, above which the thresholds for accelerating count.
constexpr double kAccelerates = 1e-6;

bool Accelerates(const JointReference& reference) noexcept {
  return std::ranges::any_of(reference.ddq_d, [](double a) { return std::abs(a) > kAccelerates; });
}

}  // namespace

void OnboardController::FillState(const JointSensors& measured, RobotState& state) noexcept {
  const JointSensors& sensors = Sound(measured);
  // Closed brakes carry torque that the observer would take for an external one.
  if (is_new_ || payload_changed_ || drive_.brakes) sensing_.Reset(sensors, setup_);
  payload_changed_ = false;
  sensing_.Update(sensors, setup_, Accelerates(generator_.joints()));
  if (config_.has_accelerometers) {
    if (is_new_) accelerometers_.Reset();
    accelerometers_.Update(config_.arm, sensing_.arm().q, sensors.dq);
  }
  Fill(sensors, state);
  if (IsFinite(state)) {
    sound_ = sensors;
  } else {
    HaltOnNoNumber();
    sensing_.Reset(sound_, setup_);
    last_tau_J_ = sound_.tau_J;
    Fill(sound_, state);
  }
  ++message_id_;
  is_new_ = false;
}

void OnboardController::Fill(const JointSensors& sensors, RobotState& state) noexcept {
  FillMeasured(sensors, state);
  FillDesired(state);
  FillModes(state);
}

void OnboardController::FillMeasured(const JointSensors& sensors, RobotState& state) noexcept {
  state.message_id = message_id_ + 1;
  state.q = sensors.q;
  state.dq = sensors.dq;
  state.tau_J = sensors.tau_J;
  state.theta = sensors.theta;
  state.dtheta = sensors.dtheta;
  for (std::size_t i = 0; i < kJoints; ++i) {
    state.dtau_J[i] = !is_new_ ? (sensors.tau_J[i] - last_tau_J_[i]) / kCycleSeconds : 0;
  }
  last_tau_J_ = sensors.tau_J;
  state.tau_J_d = tau_J_d_;
  state.O_T_EE = sensing_.arm().EE.O_T_frame;
  state.elbow = model::ElbowOf(sensors.q);
  state.tau_ext_hat_filtered = sensing_.tau_ext_hat_filtered();
  state.O_F_ext_hat_K = sensing_.O_F_ext_hat_K();
  state.K_F_ext_hat_K = sensing_.K_F_ext_hat_K();
  state.joint_contact = sensing_.joint_contact();
  state.cartesian_contact = sensing_.cartesian_contact();
  state.joint_collision = sensing_.joint_collision();
  state.cartesian_collision = sensing_.cartesian_collision();
  state.accelerometer_top = accelerometers_.top();
  state.accelerometer_bottom = accelerometers_.bottom();
}

void OnboardController::FillDesired(RobotState& state) const noexcept {
  const JointReference& joints = generator_.joints();
  state.q_d = joints.q_d;
  state.dq_d = joints.dq_d;
  state.ddq_d = joints.ddq_d;
  state.O_T_EE_d = generator_.O_T_EE_d();
  state.O_dP_EE_d = generator_.O_dP_EE_d();
  state.elbow_d = model::ElbowOf(joints.q_d);
  const CartesianReference& cartesian = generator_.cartesian();
  state.O_T_EE_c = cartesian.O_T_EE_c;
  state.O_dP_EE_c = cartesian.O_dP_EE_c;
  state.O_ddP_EE_c = cartesian.O_ddP_EE_c;
  state.elbow_c = cartesian.elbow_c;
  state.delbow_c = {cartesian.delbow_c, 0};
  state.ddelbow_c = {cartesian.ddelbow_c, 0};
  state.F_T_EE = setup_.F_T_EE;
  state.EE_T_K = setup_.EE_T_K;
  state.F_T_NE = config_.F_T_NE;
  state.NE_T_EE = config_.end_effector_frame.NE_T_EE;
  state.m_ee = config_.end_effector.m;
  state.F_x_Cee = config_.end_effector.F_x_C;
  state.I_ee = config_.end_effector.I;
  state.m_load = config_.load.m_load;
  state.F_x_Cload = config_.load.F_x_Cload;
  state.I_load = config_.load.I_load;
}

void OnboardController::FillModes(RobotState& state) const noexcept {
  const bool moving = phase_ != Phase::kNone;
  state.robot_mode = robot_mode_;
  state.motion_generator_mode = moving ? modes_.generator : MotionGeneratorMode::kIdle;
  state.controller_mode = moving ? modes_.controller : ControllerMode::kOther;
  state.errors = errors_;
  state.reflex_reason = reflex_reason_;
  state.control_command_success_rate = moving ? losses_.success_rate() : 0;
}

}  // namespace twin::onboard

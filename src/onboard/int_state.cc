#include "twin/core/time.h"
#include "twin/onboard/int.h"

// What Int reports: the robot state of a cycle.

namespace twin::onboard {

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

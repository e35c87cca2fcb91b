#include "plugins/ros2/franka_state.h"

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/ros2/conversions.h"
#include "twin/core/robot_errors.h"

namespace twin::ros2 {
namespace {

constexpr const char* kBase = "panda_link0";
constexpr const char* kFlange = "panda_link8";
constexpr const char* kEndEffector = "panda_hand_tcp";
constexpr const char* kStiffness = "panda_K";

msg::Header In(const char* frame, const msg::Header& header) {
  return {.stamp = header.stamp, .frame_id = frame};
}

template <typename V>
msg::Vector3 VectorOf(const V& values, std::size_t from = 0) {
  return {.x = values[from], .y = values[from + 1], .z = values[from + 2]};
}

msg::PoseStamped PoseOf(const Transform& T, const msg::Header& header) {
  return {.header = header, .pose = ros2::PoseOf(T)};
}

msg::WrenchStamped WrenchOf(const Vector6& F, const msg::Header& header) {
  return {.header = header, .wrench = {.force = VectorOf(F), .torque = VectorOf(F, 3)}};
}

msg::TwistStamped TwistOf(const Vector6& dP, const msg::Header& header) {
  return {.header = header, .twist = {.linear = VectorOf(dP), .angular = VectorOf(dP, 3)}};
}

msg::InertiaStamped InertiaOf(double m, const Vector3& com, const Matrix3& I,
                              const msg::Header& header) {
  return {.header = header,
          .inertia = {.m = m,
                      .com = VectorOf(com),
                      .ixx = I[0],
                      .ixy = I[1],
                      .ixz = I[2],
                      .iyy = I[4],
                      .iyz = I[5],
                      .izz = I[8]}};
}

msg::JointState JointsOf(const JointNames& names, const msg::Header& header) {
  return {.header = header,
          .name = {names.begin(), names.end()},
          .position = {},
          .velocity = {},
          .effort = {}};
}

msg::JointState JointsOf(const JointNames& names, const msg::Header& header, const JointVector& q,
                         const JointVector& dq, const JointVector& tau) {
  msg::JointState joints = JointsOf(names, header);
  joints.position = ToVector(q);
  joints.velocity = ToVector(dq);
  joints.effort = ToVector(tau);
  return joints;
}

msg::JointState TorquesOf(const JointNames& names, const msg::Header& header,
                          const JointVector& tau) {
  msg::JointState joints = JointsOf(names, header);
  joints.effort = ToVector(tau);
  return joints;
}

/// Centre of mass of end effector and load together, and the inertia about it.
msg::InertiaStamped TotalInertiaOf(const RobotState& state, const msg::Header& header) {
  const double m = state.m_ee + state.m_load;
  Vector3 com{};
  Matrix3 I{};
  for (std::size_t i = 0; m > 0 && i < 3; ++i) {
    com[i] = (state.m_ee * state.F_x_Cee[i] + state.m_load * state.F_x_Cload[i]) / m;
  }
  const auto add = [&](double mass, const Vector3& centre, const Matrix3& own) {
    const Vector3 d{centre[0] - com[0], centre[1] - com[1], centre[2] - com[2]};
    const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    for (std::size_t i = 0; i < 9; ++i) {
      I[i] += own[i] + mass * ((i % 4 == 0 ? square : 0) - d[i / 3] * d[i % 3]);
    }
  };
  add(state.m_ee, state.F_x_Cee, state.I_ee);
  add(state.m_load, state.F_x_Cload, state.I_load);
  return InertiaOf(m, com, I, header);
}

/// By their names.
msg::Errors ErrorsOf(const RobotErrors& errors) {
  static const std::map<std::string, std::size_t, std::less<>> kNumbers = [] {
    std::map<std::string, std::size_t, std::less<>> numbers;
    for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
      numbers.emplace(Name(static_cast<RobotError>(i)), i);
    }
    // These two libfranka calls otherwise.
    const auto number = [](RobotError error) { return static_cast<std::size_t>(error); };
    numbers.emplace("tau_j_range_violation", number(RobotError::kTauJRangeViolation));
    numbers.emplace("cartesian_position_motion_generator_invalid_frame",
                    number(RobotError::kCartesianPositionMotionGeneratorInvalidFrame));
    return numbers;
  }();
  msg::Errors made;
  msg::Errors::Visit(made, [&errors](std::string_view name, bool& is_raised) {
    const auto number = kNumbers.find(name);
    is_raised = number != kNumbers.end() && errors.test(number->second);
  });
  return made;
}

}  // namespace

msg::FrankaRobotState ToFrankaState(const RobotState& state, const msg::Header& header,
                                    const JointNames& names) {
  const msg::Header base = In(kBase, header);
  const msg::Header flange = In(kFlange, header);
  msg::FrankaRobotState made;
  made.header = base;
  made.collision_indicators = {
      .is_cartesian_linear_collision = VectorOf(state.cartesian_collision),
      .is_cartesian_angular_collision = VectorOf(state.cartesian_collision, 3),
      .is_cartesian_linear_contact = VectorOf(state.cartesian_contact),
      .is_cartesian_angular_contact = VectorOf(state.cartesian_contact, 3),
      .is_joint_collision = state.joint_collision,
      .is_joint_contact = state.joint_contact};
  made.measured_joint_state = JointsOf(names, base, state.q, state.dq, state.tau_J);
  made.desired_joint_state = JointsOf(names, base, state.q_d, state.dq_d, state.tau_J_d);
  made.measured_joint_motor_state = JointsOf(names, base);
  made.measured_joint_motor_state.position = ToVector(state.theta);
  made.measured_joint_motor_state.velocity = ToVector(state.dtheta);
  made.ddq_d = state.ddq_d;
  made.dtau_j = state.dtau_J;
  made.tau_ext_hat_filtered = TorquesOf(names, base, state.tau_ext_hat_filtered);
  made.elbow = {.position = state.elbow,
                .desired_position = state.elbow_d,
                .commanded_position = state.elbow_c,
                .commanded_velocity = state.delbow_c,
                .commanded_acceleration = state.ddelbow_c};
  made.k_f_ext_hat_k = WrenchOf(state.K_F_ext_hat_K, In(kStiffness, header));
  made.o_f_ext_hat_k = WrenchOf(state.O_F_ext_hat_K, base);
  made.inertia_ee = InertiaOf(state.m_ee, state.F_x_Cee, state.I_ee, flange);
  made.inertia_load = InertiaOf(state.m_load, state.F_x_Cload, state.I_load, flange);
  made.inertia_total = TotalInertiaOf(state, flange);
  made.o_t_ee = PoseOf(state.O_T_EE, base);
  made.o_t_ee_d = PoseOf(state.O_T_EE_d, base);
  made.o_t_ee_c = PoseOf(state.O_T_EE_c, base);
  made.f_t_ee = PoseOf(state.F_T_EE, flange);
  made.ee_t_k = PoseOf(state.EE_T_K, In(kEndEffector, header));
  made.o_dp_ee_d = TwistOf(state.O_dP_EE_d, base);
  made.o_dp_ee_c = TwistOf(state.O_dP_EE_c, base);
  made.o_ddp_ee_c = {
      .header = base,
      .accel = {.linear = VectorOf(state.O_ddP_EE_c), .angular = VectorOf(state.O_ddP_EE_c, 3)}};
  made.time = kCycleSeconds * static_cast<double>(state.message_id);
  made.control_command_success_rate = state.control_command_success_rate;
  made.robot_mode = static_cast<std::uint8_t>(state.robot_mode);
  made.current_errors = ErrorsOf(state.errors);
  made.last_motion_errors = ErrorsOf(state.reflex_reason);
  return made;
}

FrankaTopics::FrankaTopics(Node& node) {
  const auto advertise = [&node]<typename M>(Topic<M>& topic, const char* name) {
    topic = node.Advertise<M>(std::string("franka_robot_state_broadcaster/") + name, {});
  };
  advertise(robot_state_, "robot_state");
  advertise(current_pose_, "current_pose");
  advertise(last_desired_pose_, "last_desired_pose");
  advertise(desired_end_effector_twist_, "desired_end_effector_twist");
  advertise(measured_joint_states_, "measured_joint_states");
  advertise(external_wrench_in_base_frame_, "external_wrench_in_base_frame");
  advertise(external_wrench_in_stiffness_frame_, "external_wrench_in_stiffness_frame");
  advertise(external_joint_torques_, "external_joint_torques");
  advertise(desired_joint_states_, "desired_joint_states");
}

void FrankaTopics::Publish(const RobotState& state, const msg::Time& stamp,
                           const JointNames& names) {
  const msg::Header base{.stamp = stamp, .frame_id = kBase};
  const auto publish = [](const auto& topic, auto&& make) {
    if (topic->has_readers()) topic->Publish(make());
  };
  publish(robot_state_, [&] { return ToFrankaState(state, base, names); });
  publish(current_pose_, [&] { return PoseOf(state.O_T_EE, base); });
  publish(last_desired_pose_, [&] { return PoseOf(state.O_T_EE_d, base); });
  publish(desired_end_effector_twist_, [&] { return TwistOf(state.O_dP_EE_d, base); });
  publish(measured_joint_states_,
          [&] { return JointsOf(names, base, state.q, state.dq, state.tau_J); });
  publish(external_wrench_in_base_frame_, [&] { return WrenchOf(state.O_F_ext_hat_K, base); });
  publish(external_wrench_in_stiffness_frame_,
          [&] { return WrenchOf(state.K_F_ext_hat_K, In(kStiffness, base)); });
  publish(external_joint_torques_,
          [&] { return TorquesOf(names, base, state.tau_ext_hat_filtered); });
  publish(desired_joint_states_,
          [&] { return JointsOf(names, base, state.q_d, state.dq_d, state.tau_J_d); });
}

}  // namespace twin::ros2

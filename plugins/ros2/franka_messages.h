#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "plugins/ros2/messages.h"

// Messages, services and actions of franka_msgs, by which franka_ros2 serves a robot, as messages.h
// and action_messages.h have theirs. Layouts of franka_ros2 3.4.0. Quantities are SI and rad,
// matrices by columns; a test compares bytes and hashes with those of rosbags.
namespace twin::ros2 {
namespace msg {
namespace detail {

/// What franka_msgs answers.
struct SuccessOrError {
  bool success = false;
  std::string error;
  static void Visit(auto& m, auto&& v) {
    v("success", m.success);
    v("error", m.error);
  }
};

}  // namespace detail

struct CollisionIndicators {
  static constexpr const char* kName = "franka_msgs/msg/CollisionIndicators";
  Vector3 is_cartesian_linear_collision;  ///< level of each axis; 0: none
  Vector3 is_cartesian_angular_collision;
  Vector3 is_cartesian_linear_contact;
  Vector3 is_cartesian_angular_contact;
  std::array<double, 7> is_joint_collision{};
  std::array<double, 7> is_joint_contact{};
  static void Visit(auto& m, auto&& v) {
    v("is_cartesian_linear_collision", m.is_cartesian_linear_collision);
    v("is_cartesian_angular_collision", m.is_cartesian_angular_collision);
    v("is_cartesian_linear_contact", m.is_cartesian_linear_contact);
    v("is_cartesian_angular_contact", m.is_cartesian_angular_contact);
    v("is_joint_collision", m.is_joint_collision);
    v("is_joint_contact", m.is_joint_contact);
  }
};

struct Elbow {
  static constexpr const char* kName = "franka_msgs/msg/Elbow";
  std::array<double, 2> position{};  ///< of joint 3, rad; sign of joint 4
  std::array<double, 2> desired_position{};
  std::array<double, 2> commanded_position{};
  std::array<double, 2> commanded_velocity{};
  std::array<double, 2> commanded_acceleration{};
  static void Visit(auto& m, auto&& v) {
    v("position", m.position);
    v("desired_position", m.desired_position);
    v("commanded_position", m.commanded_position);
    v("commanded_velocity", m.commanded_velocity);
    v("commanded_acceleration", m.commanded_acceleration);
  }
};

struct Errors {
  static constexpr const char* kName = "franka_msgs/msg/Errors";
  bool joint_position_limits_violation = false;
  bool cartesian_position_limits_violation = false;
  bool self_collision_avoidance_violation = false;
  bool joint_velocity_violation = false;
  bool cartesian_velocity_violation = false;
  bool force_control_safety_violation = false;
  bool joint_reflex = false;
  bool cartesian_reflex = false;
  bool max_goal_pose_deviation_violation = false;
  bool max_path_pose_deviation_violation = false;
  bool cartesian_velocity_profile_safety_violation = false;
  bool joint_position_motion_generator_start_pose_invalid = false;
  bool joint_motion_generator_position_limits_violation = false;
  bool joint_motion_generator_velocity_limits_violation = false;
  bool joint_motion_generator_velocity_discontinuity = false;
  bool joint_motion_generator_acceleration_discontinuity = false;
  bool cartesian_position_motion_generator_start_pose_invalid = false;
  bool cartesian_motion_generator_elbow_limit_violation = false;
  bool cartesian_motion_generator_velocity_limits_violation = false;
  bool cartesian_motion_generator_velocity_discontinuity = false;
  bool cartesian_motion_generator_acceleration_discontinuity = false;
  bool cartesian_motion_generator_elbow_sign_inconsistent = false;
  bool cartesian_motion_generator_start_elbow_invalid = false;
  bool cartesian_motion_generator_joint_position_limits_violation = false;
  bool cartesian_motion_generator_joint_velocity_limits_violation = false;
  bool cartesian_motion_generator_joint_velocity_discontinuity = false;
  bool cartesian_motion_generator_joint_acceleration_discontinuity = false;
  bool cartesian_position_motion_generator_invalid_frame = false;
  bool force_controller_desired_force_tolerance_violation = false;
  bool controller_torque_discontinuity = false;
  bool start_elbow_sign_inconsistent = false;
  bool communication_constraints_violation = false;
  bool power_limit_violation = false;
  bool joint_p2p_insufficient_torque_for_planning = false;
  bool tau_j_range_violation = false;
  bool instability_detected = false;
  static void Visit(auto& m, auto&& v) {
    v("joint_position_limits_violation", m.joint_position_limits_violation);
    v("cartesian_position_limits_violation", m.cartesian_position_limits_violation);
    v("self_collision_avoidance_violation", m.self_collision_avoidance_violation);
    v("joint_velocity_violation", m.joint_velocity_violation);
    v("cartesian_velocity_violation", m.cartesian_velocity_violation);
    v("force_control_safety_violation", m.force_control_safety_violation);
    v("joint_reflex", m.joint_reflex);
    v("cartesian_reflex", m.cartesian_reflex);
    v("max_goal_pose_deviation_violation", m.max_goal_pose_deviation_violation);
    v("max_path_pose_deviation_violation", m.max_path_pose_deviation_violation);
    v("cartesian_velocity_profile_safety_violation", m.cartesian_velocity_profile_safety_violation);
    v("joint_position_motion_generator_start_pose_invalid",
      m.joint_position_motion_generator_start_pose_invalid);
    v("joint_motion_generator_position_limits_violation",
      m.joint_motion_generator_position_limits_violation);
    v("joint_motion_generator_velocity_limits_violation",
      m.joint_motion_generator_velocity_limits_violation);
    v("joint_motion_generator_velocity_discontinuity",
      m.joint_motion_generator_velocity_discontinuity);
    v("joint_motion_generator_acceleration_discontinuity",
      m.joint_motion_generator_acceleration_discontinuity);
    v("cartesian_position_motion_generator_start_pose_invalid",
      m.cartesian_position_motion_generator_start_pose_invalid);
    v("cartesian_motion_generator_elbow_limit_violation",
      m.cartesian_motion_generator_elbow_limit_violation);
    v("cartesian_motion_generator_velocity_limits_violation",
      m.cartesian_motion_generator_velocity_limits_violation);
    v("cartesian_motion_generator_velocity_discontinuity",
      m.cartesian_motion_generator_velocity_discontinuity);
    v("cartesian_motion_generator_acceleration_discontinuity",
      m.cartesian_motion_generator_acceleration_discontinuity);
    v("cartesian_motion_generator_elbow_sign_inconsistent",
      m.cartesian_motion_generator_elbow_sign_inconsistent);
    v("cartesian_motion_generator_start_elbow_invalid",
      m.cartesian_motion_generator_start_elbow_invalid);
    v("cartesian_motion_generator_joint_position_limits_violation",
      m.cartesian_motion_generator_joint_position_limits_violation);
    v("cartesian_motion_generator_joint_velocity_limits_violation",
      m.cartesian_motion_generator_joint_velocity_limits_violation);
    v("cartesian_motion_generator_joint_velocity_discontinuity",
      m.cartesian_motion_generator_joint_velocity_discontinuity);
    v("cartesian_motion_generator_joint_acceleration_discontinuity",
      m.cartesian_motion_generator_joint_acceleration_discontinuity);
    v("cartesian_position_motion_generator_invalid_frame",
      m.cartesian_position_motion_generator_invalid_frame);
    v("force_controller_desired_force_tolerance_violation",
      m.force_controller_desired_force_tolerance_violation);
    v("controller_torque_discontinuity", m.controller_torque_discontinuity);
    v("start_elbow_sign_inconsistent", m.start_elbow_sign_inconsistent);
    v("communication_constraints_violation", m.communication_constraints_violation);
    v("power_limit_violation", m.power_limit_violation);
    v("joint_p2p_insufficient_torque_for_planning", m.joint_p2p_insufficient_torque_for_planning);
    v("tau_j_range_violation", m.tau_j_range_violation);
    v("instability_detected", m.instability_detected);
  }
};

struct FrankaRobotState {
  static constexpr const char* kName = "franka_msgs/msg/FrankaRobotState";
  enum Mode : std::uint8_t {
    kOther = 0,
    kIdle = 1,
    kMove = 2,
    kGuiding = 3,
    kReflex = 4,
    kUserStopped = 5,
    kAutomaticErrorRecovery = 6,
  };
  Header header;
  CollisionIndicators collision_indicators;
  JointState measured_joint_state;        ///< q, dq, tau_J
  JointState desired_joint_state;         ///< q_d, dq_d, tau_J_d
  JointState measured_joint_motor_state;  ///< theta, dtheta
  std::array<double, 7> ddq_d{};          ///< rad/s^2
  std::array<double, 7> dtau_j{};         ///< Nm/s
  JointState tau_ext_hat_filtered;        ///< of it the effort
  Elbow elbow;
  WrenchStamped k_f_ext_hat_k;  ///< in the stiffness frame
  WrenchStamped o_f_ext_hat_k;  ///< in the base frame
  InertiaStamped inertia_ee;
  InertiaStamped inertia_load;
  InertiaStamped inertia_total;
  PoseStamped o_t_ee;
  PoseStamped o_t_ee_d;
  PoseStamped o_t_ee_c;
  PoseStamped f_t_ee;
  PoseStamped ee_t_k;
  TwistStamped o_dp_ee_d;
  TwistStamped o_dp_ee_c;
  AccelStamped o_ddp_ee_c;
  double time = 0;                          ///< s
  double control_command_success_rate = 0;  ///< 0 to 1
  std::uint8_t robot_mode = 0;              ///< Mode
  Errors current_errors;
  Errors last_motion_errors;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("collision_indicators", m.collision_indicators);
    v("measured_joint_state", m.measured_joint_state);
    v("desired_joint_state", m.desired_joint_state);
    v("measured_joint_motor_state", m.measured_joint_motor_state);
    v("ddq_d", m.ddq_d);
    v("dtau_j", m.dtau_j);
    v("tau_ext_hat_filtered", m.tau_ext_hat_filtered);
    v("elbow", m.elbow);
    v("k_f_ext_hat_k", m.k_f_ext_hat_k);
    v("o_f_ext_hat_k", m.o_f_ext_hat_k);
    v("inertia_ee", m.inertia_ee);
    v("inertia_load", m.inertia_load);
    v("inertia_total", m.inertia_total);
    v("o_t_ee", m.o_t_ee);
    v("o_t_ee_d", m.o_t_ee_d);
    v("o_t_ee_c", m.o_t_ee_c);
    v("f_t_ee", m.f_t_ee);
    v("ee_t_k", m.ee_t_k);
    v("o_dp_ee_d", m.o_dp_ee_d);
    v("o_dp_ee_c", m.o_dp_ee_c);
    v("o_ddp_ee_c", m.o_ddp_ee_c);
    v("time", m.time);
    v("control_command_success_rate", m.control_command_success_rate);
    v("robot_mode", m.robot_mode);
    v("current_errors", m.current_errors);
    v("last_motion_errors", m.last_motion_errors);
  }
};

struct GraspEpsilon {
  static constexpr const char* kName = "franka_msgs/msg/GraspEpsilon";
  double inner = 0;  ///< m
  double outer = 0;  ///< m
  static void Visit(auto& m, auto&& v) {
    v("inner", m.inner);
    v("outer", m.outer);
  }
};

struct Homing {
  static constexpr const char* kName = "franka_msgs/action/Homing";
  struct Goal : detail::Nothing {
    static constexpr const char* kName = "franka_msgs/action/Homing_Goal";
  };
  struct Result : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/action/Homing_Result";
  };
  struct Feedback : detail::Nothing {
    static constexpr const char* kName = "franka_msgs/action/Homing_Feedback";
  };
};

struct Move {
  static constexpr const char* kName = "franka_msgs/action/Move";
  struct Goal {
    static constexpr const char* kName = "franka_msgs/action/Move_Goal";
    double width = 0;  ///< m
    double speed = 0;  ///< m/s
    static void Visit(auto& m, auto&& v) {
      v("width", m.width);
      v("speed", m.speed);
    }
  };
  struct Result : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/action/Move_Result";
  };
  struct Feedback : detail::Nothing {
    static constexpr const char* kName = "franka_msgs/action/Move_Feedback";
  };
};

struct Grasp {
  static constexpr const char* kName = "franka_msgs/action/Grasp";
  struct Goal {
    static constexpr const char* kName = "franka_msgs/action/Grasp_Goal";
    double width = 0;  ///< m
    GraspEpsilon epsilon;
    double speed = 0;  ///< m/s
    double force = 0;  ///< N
    static void Visit(auto& m, auto&& v) {
      v("width", m.width);
      v("epsilon", m.epsilon);
      v("speed", m.speed);
      v("force", m.force);
    }
  };
  struct Result : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/action/Grasp_Result";
  };
  struct Feedback : detail::Nothing {
    static constexpr const char* kName = "franka_msgs/action/Grasp_Feedback";
  };
};

struct ErrorRecovery {
  static constexpr const char* kName = "franka_msgs/action/ErrorRecovery";
  struct Goal : detail::Nothing {
    static constexpr const char* kName = "franka_msgs/action/ErrorRecovery_Goal";
  };
  struct Result : detail::Nothing {
    static constexpr const char* kName = "franka_msgs/action/ErrorRecovery_Result";
  };
  struct Feedback : detail::Nothing {
    static constexpr const char* kName = "franka_msgs/action/ErrorRecovery_Feedback";
  };
};

struct SetJointStiffness {
  static constexpr const char* kName = "franka_msgs/srv/SetJointStiffness";
  struct Request {
    static constexpr const char* kName = "franka_msgs/srv/SetJointStiffness_Request";
    std::array<double, 7> joint_stiffness{};  ///< Nm/rad
    static void Visit(auto& m, auto&& v) { v("joint_stiffness", m.joint_stiffness); }
  };
  struct Response : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/srv/SetJointStiffness_Response";
  };
};

struct SetCartesianStiffness {
  static constexpr const char* kName = "franka_msgs/srv/SetCartesianStiffness";
  struct Request {
    static constexpr const char* kName = "franka_msgs/srv/SetCartesianStiffness_Request";
    std::array<double, 6> cartesian_stiffness{};  ///< N/m, then Nm/rad
    static void Visit(auto& m, auto&& v) { v("cartesian_stiffness", m.cartesian_stiffness); }
  };
  struct Response : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/srv/SetCartesianStiffness_Response";
  };
};

struct SetTCPFrame {
  static constexpr const char* kName = "franka_msgs/srv/SetTCPFrame";
  struct Request {
    static constexpr const char* kName = "franka_msgs/srv/SetTCPFrame_Request";
    /// Of the TCP in the frame of the nominal end effector.
    std::array<double, 16> transformation{};
    static void Visit(auto& m, auto&& v) { v("transformation", m.transformation); }
  };
  struct Response : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/srv/SetTCPFrame_Response";
  };
};

struct SetStiffnessFrame {
  static constexpr const char* kName = "franka_msgs/srv/SetStiffnessFrame";
  struct Request {
    static constexpr const char* kName = "franka_msgs/srv/SetStiffnessFrame_Request";
    /// Of the stiffness frame in that of the TCP.
    std::array<double, 16> transformation{};
    static void Visit(auto& m, auto&& v) { v("transformation", m.transformation); }
  };
  struct Response : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/srv/SetStiffnessFrame_Response";
  };
};

struct SetForceTorqueCollisionBehavior {
  static constexpr const char* kName = "franka_msgs/srv/SetForceTorqueCollisionBehavior";
  struct Request {
    static constexpr const char* kName = "franka_msgs/srv/SetForceTorqueCollisionBehavior_Request";
    std::array<double, 7> lower_torque_thresholds_nominal{};  ///< Nm
    std::array<double, 7> upper_torque_thresholds_nominal{};
    std::array<double, 6> lower_force_thresholds_nominal{};  ///< N, then Nm
    std::array<double, 6> upper_force_thresholds_nominal{};
    static void Visit(auto& m, auto&& v) {
      v("lower_torque_thresholds_nominal", m.lower_torque_thresholds_nominal);
      v("upper_torque_thresholds_nominal", m.upper_torque_thresholds_nominal);
      v("lower_force_thresholds_nominal", m.lower_force_thresholds_nominal);
      v("upper_force_thresholds_nominal", m.upper_force_thresholds_nominal);
    }
  };
  struct Response : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/srv/SetForceTorqueCollisionBehavior_Response";
  };
};

struct SetFullCollisionBehavior {
  static constexpr const char* kName = "franka_msgs/srv/SetFullCollisionBehavior";
  struct Request {
    static constexpr const char* kName = "franka_msgs/srv/SetFullCollisionBehavior_Request";
    std::array<double, 7> lower_torque_thresholds_acceleration{};  ///< Nm
    std::array<double, 7> upper_torque_thresholds_acceleration{};
    std::array<double, 7> lower_torque_thresholds_nominal{};
    std::array<double, 7> upper_torque_thresholds_nominal{};
    std::array<double, 6> lower_force_thresholds_acceleration{};  ///< N, then Nm
    std::array<double, 6> upper_force_thresholds_acceleration{};
    std::array<double, 6> lower_force_thresholds_nominal{};
    std::array<double, 6> upper_force_thresholds_nominal{};
    static void Visit(auto& m, auto&& v) {
      v("lower_torque_thresholds_acceleration", m.lower_torque_thresholds_acceleration);
      v("upper_torque_thresholds_acceleration", m.upper_torque_thresholds_acceleration);
      v("lower_torque_thresholds_nominal", m.lower_torque_thresholds_nominal);
      v("upper_torque_thresholds_nominal", m.upper_torque_thresholds_nominal);
      v("lower_force_thresholds_acceleration", m.lower_force_thresholds_acceleration);
      v("upper_force_thresholds_acceleration", m.upper_force_thresholds_acceleration);
      v("lower_force_thresholds_nominal", m.lower_force_thresholds_nominal);
      v("upper_force_thresholds_nominal", m.upper_force_thresholds_nominal);
    }
  };
  struct Response : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/srv/SetFullCollisionBehavior_Response";
  };
};

struct SetLoad {
  static constexpr const char* kName = "franka_msgs/srv/SetLoad";
  struct Request {
    static constexpr const char* kName = "franka_msgs/srv/SetLoad_Request";
    double mass = 0;                         ///< kg
    std::array<double, 3> center_of_mass{};  ///< m, in the flange's frame
    std::array<double, 9> load_inertia{};    ///< kg m^2
    static void Visit(auto& m, auto&& v) {
      v("mass", m.mass);
      v("center_of_mass", m.center_of_mass);
      v("load_inertia", m.load_inertia);
    }
  };
  struct Response : detail::SuccessOrError {
    static constexpr const char* kName = "franka_msgs/srv/SetLoad_Response";
  };
};

}  // namespace msg

/// Calls visitor.operator()<M>() for each message above, and for those of each service and action.
void ForEachFrankaMessage(auto&& visitor) {
  visitor.template operator()<msg::CollisionIndicators>();
  visitor.template operator()<msg::Elbow>();
  visitor.template operator()<msg::Errors>();
  visitor.template operator()<msg::FrankaRobotState>();
  visitor.template operator()<msg::GraspEpsilon>();
  visitor.template operator()<msg::Homing::Goal>();
  visitor.template operator()<msg::Homing::Result>();
  visitor.template operator()<msg::Homing::Feedback>();
  visitor.template operator()<msg::Move::Goal>();
  visitor.template operator()<msg::Move::Result>();
  visitor.template operator()<msg::Move::Feedback>();
  visitor.template operator()<msg::Grasp::Goal>();
  visitor.template operator()<msg::Grasp::Result>();
  visitor.template operator()<msg::Grasp::Feedback>();
  visitor.template operator()<msg::ErrorRecovery::Goal>();
  visitor.template operator()<msg::ErrorRecovery::Result>();
  visitor.template operator()<msg::ErrorRecovery::Feedback>();
  visitor.template operator()<msg::SetJointStiffness::Request>();
  visitor.template operator()<msg::SetJointStiffness::Response>();
  visitor.template operator()<msg::SetCartesianStiffness::Request>();
  visitor.template operator()<msg::SetCartesianStiffness::Response>();
  visitor.template operator()<msg::SetTCPFrame::Request>();
  visitor.template operator()<msg::SetTCPFrame::Response>();
  visitor.template operator()<msg::SetStiffnessFrame::Request>();
  visitor.template operator()<msg::SetStiffnessFrame::Response>();
  visitor.template operator()<msg::SetForceTorqueCollisionBehavior::Request>();
  visitor.template operator()<msg::SetForceTorqueCollisionBehavior::Response>();
  visitor.template operator()<msg::SetFullCollisionBehavior::Request>();
  visitor.template operator()<msg::SetFullCollisionBehavior::Response>();
  visitor.template operator()<msg::SetLoad::Request>();
  visitor.template operator()<msg::SetLoad::Response>();
}

}  // namespace twin::ros2

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "plugins/ros2/messages.h"

// Services and actions, as messages.h. An action A has kName ("pkg/action/Name") and the messages
// A::Goal, A::Result and A::Feedback; what carries them on the wire is made from these.
namespace twin::ros2 {
namespace msg {

struct UUID {
  static constexpr const char* kName = "unique_identifier_msgs/msg/UUID";
  std::array<std::uint8_t, 16> uuid{};
  static void Visit(auto& m, auto&& v) { v("uuid", m.uuid); }
  bool operator==(const UUID&) const = default;
};

struct GoalInfo {
  static constexpr const char* kName = "action_msgs/msg/GoalInfo";
  UUID goal_id;
  Time stamp;
  static void Visit(auto& m, auto&& v) {
    v("goal_id", m.goal_id);
    v("stamp", m.stamp);
  }
};

struct GoalStatus {
  static constexpr const char* kName = "action_msgs/msg/GoalStatus";
  GoalInfo goal_info;
  std::int8_t status = 0;  ///< ros2::GoalState
  static void Visit(auto& m, auto&& v) {
    v("goal_info", m.goal_info);
    v("status", m.status);
  }
};

struct GoalStatusArray {
  static constexpr const char* kName = "action_msgs/msg/GoalStatusArray";
  std::vector<GoalStatus> status_list;
  static void Visit(auto& m, auto&& v) { v("status_list", m.status_list); }
};

struct JointTolerance {
  static constexpr const char* kName = "control_msgs/msg/JointTolerance";
  std::string name;
  double position = 0;  ///< 0: the server's default; -1: none
  double velocity = 0;
  double acceleration = 0;
  static void Visit(auto& m, auto&& v) {
    v("name", m.name);
    v("position", m.position);
    v("velocity", m.velocity);
    v("acceleration", m.acceleration);
  }
};

struct JointComponentTolerance {
  static constexpr const char* kName = "control_msgs/msg/JointComponentTolerance";
  std::string joint_name;
  std::uint16_t component = 0;
  double position = 0;
  double velocity = 0;
  double acceleration = 0;
  static void Visit(auto& m, auto&& v) {
    v("joint_name", m.joint_name);
    v("component", m.component);
    v("position", m.position);
    v("velocity", m.velocity);
    v("acceleration", m.acceleration);
  }
};

struct GripperCommandMessage {
  static constexpr const char* kName = "control_msgs/msg/GripperCommand";
  double position = 0;
  double max_effort = 0;
  static void Visit(auto& m, auto&& v) {
    v("position", m.position);
    v("max_effort", m.max_effort);
  }
};

}  // namespace msg

struct CancelGoal {
  static constexpr const char* kName = "action_msgs/srv/CancelGoal";
  enum Code : std::int8_t {
    kNone = 0,
    kRejected = 1,
    kUnknownGoal = 2,
    kTerminated = 3,
  };
  struct Request {
    static constexpr const char* kName = "action_msgs/srv/CancelGoal_Request";
    msg::GoalInfo goal_info;
    static void Visit(auto& m, auto&& v) { v("goal_info", m.goal_info); }
  };
  struct Response {
    static constexpr const char* kName = "action_msgs/srv/CancelGoal_Response";
    std::int8_t return_code = 0;
    std::vector<msg::GoalInfo> goals_canceling;
    static void Visit(auto& m, auto&& v) {
      v("return_code", m.return_code);
      v("goals_canceling", m.goals_canceling);
    }
  };
};

struct FollowJointTrajectory {
  static constexpr const char* kName = "control_msgs/action/FollowJointTrajectory";
  enum Code : std::int32_t {
    kSuccessful = 0,
    kInvalidGoal = -1,
    kInvalidJoints = -2,
    kOldHeaderTimestamp = -3,
    kPathToleranceViolated = -4,
    kGoalToleranceViolated = -5,
  };
  struct Goal {
    static constexpr const char* kName = "control_msgs/action/FollowJointTrajectory_Goal";
    msg::JointTrajectory trajectory;
    msg::MultiDOFJointTrajectory multi_dof_trajectory;
    std::vector<msg::JointTolerance> path_tolerance;
    std::vector<msg::JointComponentTolerance> component_path_tolerance;
    std::vector<msg::JointTolerance> goal_tolerance;
    std::vector<msg::JointComponentTolerance> component_goal_tolerance;
    msg::Duration goal_time_tolerance;
    static void Visit(auto& m, auto&& v) {
      v("trajectory", m.trajectory);
      v("multi_dof_trajectory", m.multi_dof_trajectory);
      v("path_tolerance", m.path_tolerance);
      v("component_path_tolerance", m.component_path_tolerance);
      v("goal_tolerance", m.goal_tolerance);
      v("component_goal_tolerance", m.component_goal_tolerance);
      v("goal_time_tolerance", m.goal_time_tolerance);
    }
  };
  struct Result {
    static constexpr const char* kName = "control_msgs/action/FollowJointTrajectory_Result";
    std::int32_t error_code = 0;  ///< Code
    std::string error_string;
    static void Visit(auto& m, auto&& v) {
      v("error_code", m.error_code);
      v("error_string", m.error_string);
    }
  };
  /// As of control_msgs 5, of Jazzy and before.
  struct Feedback {
    static constexpr const char* kName = "control_msgs/action/FollowJointTrajectory_Feedback";
    msg::Header header;
    std::vector<std::string> joint_names;
    msg::JointTrajectoryPoint desired;
    msg::JointTrajectoryPoint actual;
    msg::JointTrajectoryPoint error;
    std::vector<std::string> multi_dof_joint_names;
    msg::MultiDOFJointTrajectoryPoint multi_dof_desired;
    msg::MultiDOFJointTrajectoryPoint multi_dof_actual;
    msg::MultiDOFJointTrajectoryPoint multi_dof_error;
    static void Visit(auto& m, auto&& v) {
      v("header", m.header);
      v("joint_names", m.joint_names);
      v("desired", m.desired);
      v("actual", m.actual);
      v("error", m.error);
      v("multi_dof_joint_names", m.multi_dof_joint_names);
      v("multi_dof_desired", m.multi_dof_desired);
      v("multi_dof_actual", m.multi_dof_actual);
      v("multi_dof_error", m.multi_dof_error);
    }
  };
};

struct GripperCommand {
  static constexpr const char* kName = "control_msgs/action/GripperCommand";
  struct Goal {
    static constexpr const char* kName = "control_msgs/action/GripperCommand_Goal";
    msg::GripperCommandMessage command;
    static void Visit(auto& m, auto&& v) { v("command", m.command); }
  };
  struct Result {
    static constexpr const char* kName = "control_msgs/action/GripperCommand_Result";
    double position = 0;
    double effort = 0;
    bool stalled = false;
    bool reached_goal = false;
    static void Visit(auto& m, auto&& v) {
      v("position", m.position);
      v("effort", m.effort);
      v("stalled", m.stalled);
      v("reached_goal", m.reached_goal);
    }
  };
  struct Feedback {
    static constexpr const char* kName = "control_msgs/action/GripperCommand_Feedback";
    double position = 0;
    double effort = 0;
    bool stalled = false;
    bool reached_goal = false;
    static void Visit(auto& m, auto&& v) {
      v("position", m.position);
      v("effort", m.effort);
      v("stalled", m.stalled);
      v("reached_goal", m.reached_goal);
    }
  };
};

/// Of std_srvs.
struct SetBool {
  static constexpr const char* kName = "std_srvs/srv/SetBool";
  struct Request {
    static constexpr const char* kName = "std_srvs/srv/SetBool_Request";
    bool data = false;
    static void Visit(auto& m, auto&& v) { v("data", m.data); }
  };
  struct Response {
    static constexpr const char* kName = "std_srvs/srv/SetBool_Response";
    bool success = false;
    std::string message;
    static void Visit(auto& m, auto&& v) {
      v("success", m.success);
      v("message", m.message);
    }
  };
};

struct Trigger {
  static constexpr const char* kName = "std_srvs/srv/Trigger";
  struct Request : msg::detail::Nothing {
    static constexpr const char* kName = "std_srvs/srv/Trigger_Request";
  };
  struct Response {
    static constexpr const char* kName = "std_srvs/srv/Trigger_Response";
    bool success = false;
    std::string message;
    static void Visit(auto& m, auto&& v) {
      v("success", m.success);
      v("message", m.message);
    }
  };
};

/// What carries an action's messages. Names: the action's with kSuffix.
template <typename A>
struct SendGoal {
  struct Request {
    using Of = A;
    static constexpr const char* kSuffix = "_SendGoal_Request";
    msg::UUID goal_id;
    typename A::Goal goal;
    static void Visit(auto& m, auto&& v) {
      v("goal_id", m.goal_id);
      v("goal", m.goal);
    }
  };
  struct Response {
    using Of = A;
    static constexpr const char* kSuffix = "_SendGoal_Response";
    bool accepted = false;
    msg::Time stamp;
    static void Visit(auto& m, auto&& v) {
      v("accepted", m.accepted);
      v("stamp", m.stamp);
    }
  };
};

template <typename A>
struct GetResult {
  struct Request {
    using Of = A;
    static constexpr const char* kSuffix = "_GetResult_Request";
    msg::UUID goal_id;
    static void Visit(auto& m, auto&& v) { v("goal_id", m.goal_id); }
  };
  struct Response {
    using Of = A;
    static constexpr const char* kSuffix = "_GetResult_Response";
    std::int8_t status = 0;  ///< ros2::GoalState
    typename A::Result result;
    static void Visit(auto& m, auto&& v) {
      v("status", m.status);
      v("result", m.result);
    }
  };
};

template <typename A>
struct FeedbackMessage {
  using Of = A;
  static constexpr const char* kSuffix = "_FeedbackMessage";
  msg::UUID goal_id;
  typename A::Feedback feedback;
  static void Visit(auto& m, auto&& v) {
    v("goal_id", m.goal_id);
    v("feedback", m.feedback);
  }
};

}  // namespace twin::ros2

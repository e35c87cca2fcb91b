#pragma once

#include <memory>
#include <string>

#include "plugins/ros2/franka_messages.h"
#include "plugins/ros2/node.h"
#include "plugins/ros2/trajectory_goal.h"
#include "twin/core/robot_state.h"

namespace twin::ros2 {

/// The robot's state as franka_msgs has it. Frames are called panda_link0 (O), panda_link8 (F),
/// panda_hand_tcp (EE) and panda_K (K).
[[nodiscard]] msg::FrankaRobotState ToFrankaState(const RobotState& state,
                                                  const msg::Header& header,
                                                  const JointNames& names);

/// The topics of franka_ros2's franka_robot_state_broadcaster. What nobody reads is not made.
///
/// Threads: one after construction.
class FrankaTopics {
 public:
  explicit FrankaTopics(Node& node);

  void Publish(const RobotState& state, const msg::Time& stamp, const JointNames& names);

 private:
  template <typename M>
  using Topic = std::unique_ptr<Publisher<M>>;

  Topic<msg::FrankaRobotState> robot_state_;
  Topic<msg::PoseStamped> current_pose_;
  Topic<msg::PoseStamped> last_desired_pose_;
  Topic<msg::TwistStamped> desired_end_effector_twist_;
  Topic<msg::JointState> measured_joint_states_;
  Topic<msg::WrenchStamped> external_wrench_in_base_frame_;
  Topic<msg::WrenchStamped> external_wrench_in_stiffness_frame_;
  Topic<msg::JointState> external_joint_torques_;
  Topic<msg::JointState> desired_joint_states_;
};

}  // namespace twin::ros2

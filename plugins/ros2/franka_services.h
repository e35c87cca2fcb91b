#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "plugins/ros2/action_server.h"
#include "plugins/ros2/arm_commander.h"
#include "plugins/ros2/franka_messages.h"
#include "plugins/ros2/hand_commander.h"

namespace twin::ros2 {

/// The services and the action by which franka_ros2 sets the arm up: below service_server, and
/// action_server/error_recovery. While the arm moves they refuse: it is set at rest.
class FrankaArmServices {
 public:
  /// @param now  of the clock of stamps; any thread.
  FrankaArmServices(Node& node, ArmCommander& arm, const std::function<msg::Time()>& now);

 private:
  ArmCommander& arm_;
  ActionServer<msg::ErrorRecovery> recovery_;
};

/// The actions of franka_gripper: homing, move and grasp below panda_gripper.
class FrankaHandActions {
 public:
  FrankaHandActions(Node& node, HandCommander& hand, const std::function<msg::Time()>& now);

 private:
  /// One of them.
  template <typename A>
  struct Action;

  std::shared_ptr<void> homing_, move_, grasp_;
};

/// Brings the robot back from a reflex. @param end  receives why not; empty: the robot is Idle. On
/// the commander's thread, or at once when the arm is busy.
void Recover(ArmCommander& arm, const std::function<void(const std::string& why)>& end);

}  // namespace twin::ros2

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "plugins/ros2/camera_topics.h"
#include "plugins/ros2/node.h"
#include "plugins/ros2/simulation_services.h"
#include "plugins/ros2/state_tap.h"
#include "twin/core/hand_command.h"
#include "twin/fci/sockets.h"
#include "twin/run/catalogue.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

namespace twin::ros2 {

/// What a robot is to ROS nodes. Names without a slash at first are below the namespace.
struct BridgeOptions {
  NodeOptions node{};
  double rate_hz = 100;  ///< of joint_states and /clock, in [1, 1000]
  /// Time stands until robot_joint_states, of this rate, in [1, 1000] Hz, are answered; absent: it
  /// passes.
  std::optional<double> lockstep_hz{};
  bool has_clock = true;  ///< publishes /clock
  bool arms = false;      ///< robot_joint_commands is armed from the start
  std::string joint_prefix = "panda_joint";
  std::string finger_prefix = "panda_finger_joint";
  std::string arm_action = "panda_arm_controller/follow_joint_trajectory";
  std::string hand_action = "panda_hand_controller/gripper_cmd";
};

/// The robot behind it. Everything must outlive the bridge.
struct BridgedRobot {
  const run::Catalogue& catalogue;
  run::RunFiles files;
  scenario::Scenario client;     ///< application::OwnClientOf
  run::RealtimeConfig settings;  ///< where commands are sent
  scenario::RobotData data;
  /// One client is connected all the time: states come by it alone. False: they come from where
  /// the robot is served, and others command it too.
  bool keeps_connection = false;
  /// The hand's state where it is served; empty: it is read over the network. @throws Error while
  /// it is not known.
  std::function<HandState()> hand{};
  std::optional<Simulation> simulation{};  ///< of a robot that is simulated here
  std::optional<Cameras> cameras{};
  /// Robot time passes as the wall clock's: stamps are then never behind it by more than 0.1 s,
  /// until time is paused.
  bool follows_wall_clock = true;
};

/// A robot in the ROS 2 graph: its states as topics, its motions as actions, and a stream of joint
/// positions. Stamps are calendar time at the bridge's start plus the robot's time, in lockstep the
/// robot's time alone, and so is /clock.
///
/// Threads: one constructs and ends it; it has threads of its own for what it publishes, and for
/// commands.
class Bridge {
 public:
  /// @param tap  of the robot's cycles; must outlive this.
  /// @throws InputError for options that are wrong; EnvironmentError as Node.
  Bridge(const BridgeOptions& options, BridgedRobot robot, StateTap& tap);
  ~Bridge();
  Bridge(const Bridge&) = delete;
  Bridge& operator=(const Bridge&) = delete;

  /// Domain, names of topics and actions: lines for users.
  [[nodiscard]] std::string Introduction() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::ros2

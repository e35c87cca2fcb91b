#pragma once

#include <functional>
#include <memory>
#include <string>

#include "plugins/ros2/action_server.h"
#include "plugins/ros2/arm_commander.h"
#include "plugins/ros2/trajectory_goal.h"

namespace twin::ros2 {

/// The action FollowJointTrajectory of an arm: the server that MoveIt and other planners command.
///
/// A goal begins when the arm rests after the one before it, which ends as aborted; its path begins
/// where the arm is. It succeeds when the arm rests at its end within the goal's tolerances.
///
/// Threads: one; the handlers run on the node's.
class TrajectoryAction {
 public:
  /// @param now  of the clock of stamps; any thread.
  /// @param why_not  why a goal may not begin now; empty: it may.
  TrajectoryAction(Node& node, const std::string& name, ArmCommander& arm, JointNames names,
                   std::function<Time()> now, std::function<std::string()> why_not);
  ~TrajectoryAction();

 private:
  class Follow;
  using Server = ActionServer<FollowJointTrajectory>;

  void Begin(const msg::UUID& id, FollowJointTrajectory::Goal&& goal);
  void Cancel(const msg::UUID& id);

  ArmCommander& arm_;
  const JointNames names_;
  const std::function<Time()> now_;
  const std::function<std::string()> why_not_;
  std::weak_ptr<Follow> current_;  ///< of the node's thread
  Server server_;
};

}  // namespace twin::ros2

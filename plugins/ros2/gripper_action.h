#pragma once

#include <memory>
#include <string>

#include "plugins/ros2/action_server.h"
#include "plugins/ros2/hand_commander.h"

namespace twin::ros2 {

/// The action control_msgs/action/GripperCommand of the hand: MoveIt's. `position` is that of one
/// finger, as in the robot's description: half of the opening, m. Opening is a move; closing with
/// max_effort (N) above 0 is a grasp of whatever lies between the fingers, else a move too.
///
/// It succeeds when the fingers are there, or hold something.
class GripperAction {
 public:
  /// @param now  of the clock of stamps; any thread.
  GripperAction(Node& node, const std::string& name, HandCommander& hand,
                std::function<msg::Time()> now);

 private:
  void Begin(const msg::UUID& id, const GripperCommand::Goal& goal);

  HandCommander& hand_;
  msg::UUID current_;                               ///< of the node's thread
  std::shared_ptr<std::atomic<bool>> is_canceled_;  ///< the current one
  ActionServer<GripperCommand> server_;
};

}  // namespace twin::ros2

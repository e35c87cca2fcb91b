#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "plugins/ros2/action_messages.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/reference/trajectory.h"

// Goals of control_msgs/action/FollowJointTrajectory, from the network to a path of the arm.
namespace twin::ros2 {

using JointNames = std::array<std::string, kJoints>;

/// "panda_joint1" to "panda_joint7", for the prefix "panda_joint".
[[nodiscard]] JointNames NamesOf(std::string_view prefix);

/// Per joint, rad; infinite: none.
struct Tolerance {
  JointVector position{};
};

/// A goal that the arm can follow.
struct JointGoal {
  reference::Trajectory trajectory;  ///< from the arm's reference on
  /// The goal's first point less the arm's reference; the path leads over it in its first second.
  JointVector offset{};
  Tolerance path;
  Tolerance end;
  twin::Duration end_time{};  ///< within which the end's tolerance must be met after the path's end
};

struct GoalRefusal {
  FollowJointTrajectory::Code code = FollowJointTrajectory::kInvalidGoal;
  std::string why;
};

/// What a goal is judged by.
struct GoalContext {
  JointNames names;
  JointLimits limits;
  JointVector q_d{};  ///< rad, where the arm rests
  Time now{};         ///< of the clock of stamps
};

/// Largest distance of a goal's first point, at time 0, from the arm, rad: MoveIt's own default
/// (allowed_start_tolerance) is 0.01, and planners begin at the measured position.
inline constexpr double kGoalStartTolerance = 0.02;

/// Positions, velocities and accelerations are interpolated as joint_trajectory_controller does
/// (linear is none: a path through positions alone is the smoothest one), sampled, and made a path
/// of bounded jerk through the samples. Source: the action's definition in control_msgs 5, and the
/// documentation of ros2_controllers' joint_trajectory_controller.
[[nodiscard]] std::variant<JointGoal, GoalRefusal> ReadGoal(const FollowJointTrajectory::Goal& goal,
                                                            const GoalContext& context);

}  // namespace twin::ros2

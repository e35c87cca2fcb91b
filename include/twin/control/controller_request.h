#pragma once

#include "twin/control/controller.h"
#include "twin/control/live_reference.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/model/arm_model.h"
#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"

namespace twin::control {

/// What a controller's factory gets: what there is to follow, and what is known of the arm. All
/// that is referred to outlives the controller.
struct ControllerRequest {
  /// The motion's path through joint space. Of a motion of poses: where the arm begins, at rest for
  /// as long as the poses take.
  const reference::Trajectory& trajectory;
  /// motion.interface of the scenario: what is to be commanded.
  CommandInterface interface = CommandInterface::kJointPosition;
  /// The motion's path of end effector poses; null when it is one through joint space.
  const reference::PoseTrajectory* poses = nullptr;
  /// Who leads the end effector while the motion goes on; null: nobody does.
  LiveReference* live = nullptr;
  const model::ArmModel& arm = model::ArmModel::Panda();
  JointLimits limits{};
  CartesianLimits cartesian{};
  /// End effector in the flange frame, as the scenario has it. A state says what the robot has.
  Transform F_T_EE = kIdentityTransform;
  /// Share of the joints' friction (model/joint_friction.h) that the robot itself makes up for.
  double friction_compensated = 0;
};

}  // namespace twin::control

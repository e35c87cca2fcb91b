#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/control/controller.h"
#include "twin/control/live_reference.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/registry.h"
#include "twin/model/arm_model.h"
#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"

namespace twin::control {

/// Arguments of a controller's factory: the reference to follow and the data of the arm. All
/// referenced objects outlive the controller.
struct ControllerRequest {
  /// The motion's joint trajectory. For a motion of poses: the start configuration, held for the
  /// duration of the poses.
  const reference::Trajectory& trajectory;
  /// The commanded quantity: motion.interface of the scenario.
  CommandInterface interface = CommandInterface::kJointPosition;
  /// The motion's trajectory of end-effector poses; null for a joint-space motion.
  const reference::PoseTrajectory* poses = nullptr;
  /// Live reference that leads the end effector during the motion; null without an operator.
  LiveReference* live = nullptr;
  const model::ArmModel& arm = model::ArmModel::Panda();
  JointLimits limits{};
  CartesianLimits cartesian{};
  /// End effector in the flange frame, from the scenario. A RobotState has the robot's value.
  Transform F_T_EE = kIdentityTransform;
  /// Share of the joint friction (model/arm_model.h) that the robot compensates.
  double friction_compensated = 0;
};

using ControllerFactory = std::function<std::unique_ptr<Controller>(const ControllerRequest&)>;

/// The program's controllers by name. The program's main fills it from an explicit list.
///
/// Threads: one thread.
class ControllerRegistry : public Registry<ControllerFactory> {
 public:
  ControllerRegistry() : Registry("controller") {}
};

}  // namespace twin::control

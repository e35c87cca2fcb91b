#include "controllers/registration.h"

#include <memory>
#include <string_view>

#include <fmt/format.h>

#include "controllers/cartesian_pose.h"
#include "controllers/compliance.h"
#include "controllers/gravity_hold.h"
#include "controllers/joint_position.h"
#include "controllers/joint_trajectory.h"
#include "controllers/joint_trajectory_effort.h"
#include "controllers/joint_velocity.h"
#include "twin/core/error.h"

namespace twin::controllers {
namespace {

using control::CommandInterface;
using control::Controller;
using control::ControllerRequest;

void RequireInterface(const ControllerRequest& request, CommandInterface wanted,
                      std::string_view text) {
  if (request.interface != wanted) throw InputError(std::string(text));
}

/// A joint-space controller cannot follow a motion of poses.
void RequireJointPath(const ControllerRequest& request, std::string_view name) {
  if (request.poses == nullptr) return;
  throw InputError(
      fmt::format("controller {} follows a path through joint space, and the motion is one of "
                  "poses; give motion.trajectory, or let controller.type be cartesian_pose or "
                  "compliance",
                  name));
}

std::unique_ptr<Controller> MakeJointTrajectory(const ControllerRequest& request) {
  if (request.interface == CommandInterface::kTorque) {
    throw InputError(
        "controller joint_trajectory commands no torques; set motion.interface to joint_position, "
        "joint_velocity or cartesian_pose, or controller.type to joint_trajectory_effort");
  }
  RequireJointPath(request, "joint_trajectory");
  JointTrajectoryOptions options;
  options.command_interface = request.interface;
  return std::make_unique<JointTrajectoryController>(request.trajectory, options);
}

std::unique_ptr<Controller> MakeJointTrajectoryEffort(const ControllerRequest& request) {
  RequireInterface(
      request, CommandInterface::kTorque,
      "controller joint_trajectory_effort commands torques; set motion.interface to torque");
  RequireJointPath(request, "joint_trajectory_effort");
  return std::make_unique<JointTrajectoryEffortController>(request.trajectory);
}

std::unique_ptr<Controller> MakeJointPosition(const ControllerRequest& request) {
  RequireInterface(
      request, CommandInterface::kJointPosition,
      "controller joint_position commands joint positions; set motion.interface to joint_position");
  RequireJointPath(request, "joint_position");
  return std::make_unique<JointPositionController>(request);
}

std::unique_ptr<Controller> MakeJointVelocity(const ControllerRequest& request) {
  RequireInterface(request, CommandInterface::kJointVelocity,
                   "controller joint_velocity commands joint velocities; set motion.interface to "
                   "joint_velocity");
  RequireJointPath(request, "joint_velocity");
  return std::make_unique<JointVelocityController>(request);
}

std::unique_ptr<Controller> MakeCartesianPose(const ControllerRequest& request) {
  RequireInterface(
      request, CommandInterface::kJointPosition,
      "controller cartesian_pose commands joint positions; set motion.interface to joint_position");
  return std::make_unique<CartesianPoseController>(request);
}

std::unique_ptr<Controller> MakeCompliance(const ControllerRequest& request) {
  RequireInterface(request, CommandInterface::kTorque,
                   "controller compliance commands torques; set motion.interface to torque");
  return std::make_unique<ComplianceController>(request);
}

std::unique_ptr<Controller> MakeGravityHold(const ControllerRequest& request) {
  RequireInterface(request, CommandInterface::kTorque,
                   "controller gravity_hold commands torques; set motion.interface to torque");
  return std::make_unique<GravityHoldController>(request);
}

}  // namespace

void RegisterControllers(control::ControllerRegistry& registry) {
  registry.Add("joint_trajectory", &MakeJointTrajectory);
  registry.Add("joint_position", &MakeJointPosition);
  registry.Add("joint_velocity", &MakeJointVelocity);
  registry.Add("cartesian_pose", &MakeCartesianPose);
  registry.Add("joint_trajectory_effort", &MakeJointTrajectoryEffort);
  registry.Add("joint_effort", &MakeJointTrajectoryEffort);
  registry.Add("compliance", &MakeCompliance);
  registry.Add("gravity_hold", &MakeGravityHold);
}

}  // namespace twin::controllers

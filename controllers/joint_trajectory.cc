#include "controllers/joint_trajectory.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/model/arm_model.h"

namespace twin::controllers {

JointTrajectoryController::JointTrajectoryController(reference::Trajectory trajectory,
                                                     const JointTrajectoryOptions& options)
    : trajectory_(std::move(trajectory)), options_(options) {}

void JointTrajectoryController::Configure(control::ParameterReader& parameters) {
  options_.give_velocity = parameters.Bool("give_velocity", options_.give_velocity);
}

void JointTrajectoryController::Activate(const RobotState& state, Time /*now*/) {
  is_running_ = false;
  F_T_EE_ = state.F_T_EE;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double first = trajectory_.start()[j];
    if (std::abs(state.q_d[j] - first) <= reference::kStartTolerance) continue;
    throw InputError(
        fmt::format("joint trajectory: joint {} of the robot is at {:.6f} rad, the trajectory "
                    "starts at {:.6f} rad; they may differ by {} rad. Move the robot to the first "
                    "point, or let the trajectory start where the robot is",
                    j + 1, state.q_d[j], first, reference::kStartTolerance));
  }
}

void JointTrajectoryController::Update(const RobotState& /*state*/, Time now,
                                       control::ControllerOutput& output) noexcept {
  if (!is_running_) {
    is_running_ = true;
    start_ = now;
  }
  const Duration elapsed = now - start_;
  output.target.joint = trajectory_.Sample(elapsed);
  if (options_.command_interface == control::CommandInterface::kCartesianPose) {
    const model::ArmModel& arm = model::ArmModel::Panda();
    const model::Configuration q(output.target.joint.q);
    output.target.pose.O_T_EE = arm.Pose(model::Frame::kEndEffector, q, F_T_EE_);
    output.target.pose.O_dP_EE =
        arm.Twist(model::Frame::kEndEffector, q, output.target.joint.dq, F_T_EE_);
  }
  output.has_velocity = options_.give_velocity ||
                        options_.command_interface == control::CommandInterface::kJointVelocity;
  output.finished = elapsed >= trajectory_.duration();
}

}  // namespace twin::controllers

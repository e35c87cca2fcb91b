#include "controllers/joint_velocity.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::controllers {

JointVelocityController::JointVelocityController(const control::ControllerRequest& request,
                                                 const JointVelocityOptions& options)
    : trajectory_(request.trajectory), options_(options) {}

void JointVelocityController::Configure(control::ParameterReader& p) {
  options_.K = p.Quantity("K", Dimension::kRate, options_.K, 0, 50);
  options_.start_tolerance_rad =
      p.Quantity("start_tolerance", Dimension::kAngle, options_.start_tolerance_rad, 1e-9, 0.1);
  options_.goal_tolerance_rad =
      p.Quantity("goal_tolerance", Dimension::kAngle, options_.goal_tolerance_rad, 1e-9, 0.1);
  options_.goal_time =
      p.Time("goal_time", options_.goal_time, Duration::zero(), std::chrono::seconds(60));
}

void JointVelocityController::Activate(const RobotState& state, Time /*now*/) {
  is_running_ = false;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double first = trajectory_.start()[j];
    if (std::abs(state.q_d[j] - first) <= options_.start_tolerance_rad) continue;
    throw InputError(
        fmt::format("joint_velocity: joint {} of the robot is at {:.6f} rad, the trajectory starts "
                    "at {:.6f} rad; they may differ by {} rad. Move the robot to the first point, "
                    "or let the trajectory start where the robot is",
                    j + 1, state.q_d[j], first, options_.start_tolerance_rad));
  }
}

void JointVelocityController::Update(const RobotState& state, Time now,
                                     control::ControllerOutput& output) noexcept {
  if (!is_running_) {
    is_running_ = true;
    is_finished_ = false;
    start_ = now;
  }
  const Duration elapsed = now - start_;
  const double x = std::clamp(ToSeconds(elapsed), 0.0, 1.0);
  const double K = options_.K * x * x * x * (10 + x * (-15 + 6 * x));
  reference::JointTarget& target = output.target.joint;
  target = trajectory_.Sample(elapsed);
  const Duration over = elapsed - trajectory_.duration();
  is_finished_ =
      is_finished_ || over >= options_.goal_time || (over >= Duration::zero() && IsThere(state));
  for (std::size_t j = 0; j < kJoints; ++j) {
    target.dq[j] = is_finished_ ? 0 : target.dq[j] + K * (target.q[j] - state.q_d[j]);
  }
  output.has_velocity = true;
  output.failed = false;
  output.finished = is_finished_;
}

bool JointVelocityController::IsThere(const RobotState& state) const noexcept {
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double distance = std::abs(trajectory_.goal()[j] - state.q_d[j]);
    if (!(distance <= options_.goal_tolerance_rad)) return false;
  }
  return true;
}

}  // namespace twin::controllers

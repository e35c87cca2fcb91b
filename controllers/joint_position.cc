#include "controllers/joint_position.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::controllers {

JointPositionController::JointPositionController(const control::ControllerRequest& request,
                                                 const JointPositionOptions& options)
    : trajectory_(request.trajectory), options_(options) {}

void JointPositionController::Configure(control::ParameterReader& p) {
  options_.start_tolerance_rad =
      p.Quantity("start_tolerance", Dimension::kAngle, options_.start_tolerance_rad, 1e-9, 0.1);
  options_.blend =
      p.Time("blend", options_.blend, std::chrono::milliseconds(100), std::chrono::seconds(60));
}

void JointPositionController::Activate(const RobotState& state, Time /*now*/) {
  is_running_ = false;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double first = trajectory_.start()[j];
    if (std::abs(state.q_d[j] - first) <= options_.start_tolerance_rad) continue;
    throw InputError(
        fmt::format("joint_position: joint {} of the robot is at {:.6f} rad, the trajectory starts "
                    "at {:.6f} rad; they may differ by {} rad. Move the robot to the first point, "
                    "or let the trajectory start where the robot is",
                    j + 1, state.q_d[j], first, options_.start_tolerance_rad));
  }
}

void JointPositionController::Update(const RobotState& state, Time now,
                                     control::ControllerOutput& output) noexcept {
  if (!is_running_) {
    is_running_ = true;
    start_ = now;
    for (std::size_t j = 0; j < kJoints; ++j) offset_[j] = state.q_d[j] - trajectory_.start()[j];
  }
  const Duration elapsed = now - start_;
  const double T = ToSeconds(options_.blend);
  const double x = std::clamp(ToSeconds(elapsed) / T, 0.0, 1.0);
  const double s = x * x * x * (10 + x * (-15 + 6 * x));
  const double ds = 30 * x * x * (1 - x) * (1 - x) / T;
  reference::JointTarget& target = output.target.joint;
  target = trajectory_.Sample(elapsed);
  for (std::size_t j = 0; j < kJoints; ++j) {
    target.q[j] += (1 - s) * offset_[j];
    target.dq[j] -= ds * offset_[j];
  }
  output.has_velocity = true;
  output.failed = false;
  output.finished = elapsed >= std::max(trajectory_.duration(), options_.blend);
}

}  // namespace twin::controllers

#include "controllers/joint_effort.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/require.h"

namespace twin::controllers {
namespace {

JointEffortOptions Validated(const JointEffortOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

void JointEffortOptions::Validate() const {
  for (std::size_t j = 0; j < kJoints; ++j) {
    RequireInRange(fmt::format("joint effort: K_P[{}]", j), K_P[j], 0, 1e4);
    RequireInRange(fmt::format("joint effort: K_I[{}]", j), K_I[j], 0, 1e4);
    RequireInRange(fmt::format("joint effort: K_D[{}]", j), K_D[j], 0, 1e3);
    RequireInRange(fmt::format("joint effort: integral_max[{}]", j), integral_max[j], 0, 100);
  }
  RequireInRange("joint effort: soft_start in s", ToSeconds(soft_start), 0, 10);
  RequireInRange("joint effort: start_tolerance_rad", start_tolerance_rad, 1e-9, 0.1);
  RequireInRange("joint effort: settled_distance_rad", settled_distance_rad, 1e-9, 1);
  RequireInRange("joint effort: settled_speed_rad_per_s", settled_speed_rad_per_s, 1e-9, 1);
  RequireInRange("joint effort: settling_time in s", ToSeconds(settling_time), 0, 60);
}

JointEffortController::JointEffortController(reference::Trajectory trajectory,
                                             const JointEffortOptions& options)
    : trajectory_(std::move(trajectory)), options_(Validated(options)) {}

void JointEffortController::Activate(const RobotState& state, Time /*now*/) {
  is_running_ = false;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double first = trajectory_.start()[j];
    if (std::abs(state.q[j] - first) <= options_.start_tolerance_rad) continue;
    throw InputError(
        fmt::format("joint effort: joint {} of the robot is at {:.6f} rad, the trajectory starts "
                    "at {:.6f} rad; they may differ by {} rad. Move the robot to the first point, "
                    "or let the trajectory start where the robot is",
                    j + 1, state.q[j], first, options_.start_tolerance_rad));
  }
}

void JointEffortController::Update(const RobotState& state, Time now,
                                   control::ControllerOutput& output) noexcept {
  const bool is_first = !is_running_;
  if (is_first) Begin(now);
  const Duration elapsed = now - start_;
  output.target.joint = trajectory_.Sample(elapsed);
  JointVector tau = Law(output.target.joint, state, ToSeconds(now - last_));
  last_ = now;

  if (is_first) {
    for (std::size_t j = 0; j < kJoints; ++j) bump_[j] = state.tau_J_d[j] - tau[j];
  }
  if (elapsed < options_.soft_start) {
    const double f = 1 - ToSeconds(elapsed) / ToSeconds(options_.soft_start);
    for (std::size_t j = 0; j < kJoints; ++j) tau[j] += f * bump_[j];
  }
  output.target.tau_J_d = tau;
  output.has_velocity = false;

  const Duration over = elapsed - trajectory_.duration();
  is_finished_ = is_finished_ || over >= options_.settling_time ||
                 (over >= Duration::zero() && IsSettled(state));
  output.finished = is_finished_;
}

void JointEffortController::Begin(Time now) noexcept {
  is_running_ = true;
  is_finished_ = false;
  start_ = now;
  last_ = now;
  integral_ = JointVector{};
}

JointVector JointEffortController::Law(const reference::JointTarget& target,
                                       const RobotState& state, double dt) noexcept {
  JointVector tau{};
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double error = target.q[j] - state.q[j];
    integral_[j] = std::clamp(integral_[j] + options_.K_I[j] * error * dt,
                              -options_.integral_max[j], options_.integral_max[j]);
    tau[j] =
        options_.K_P[j] * error + integral_[j] + options_.K_D[j] * (target.dq[j] - state.dq[j]);
  }
  return tau;
}

bool JointEffortController::IsSettled(const RobotState& state) const noexcept {
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double distance = std::abs(trajectory_.goal()[j] - state.q[j]);
    if (!(distance <= options_.settled_distance_rad)) return false;
    if (!(std::abs(state.dq[j]) <= options_.settled_speed_rad_per_s)) return false;
  }
  return true;
}

}  // namespace twin::controllers

#include "controllers/joint_trajectory_effort.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::controllers {
namespace {

constexpr const char* kName = "joint trajectory effort";

JointTrajectoryEffortOptions Validated(const JointTrajectoryEffortOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

void JointTrajectoryEffortOptions::Validate() const {
  const auto require = [](const char* field, std::size_t j, double value, double most) {
    RequireInRange(fmt::format("{}: {}[{}]", kName, field, j), value, 0, most);
  };
  for (std::size_t j = 0; j < kJoints; ++j) {
    require("K_P", j, K_P[j], 1e4);
    require("K_I", j, K_I[j], 1e4);
    require("K_D", j, K_D[j], 1e3);
    require("integral_max", j, integral_max[j], 100);
    require("path_tolerance", j, path_tolerance[j], 10);
    require("goal_tolerance", j, goal_tolerance[j], 10);
  }
  const auto require_one = [](const char* field, double value, double least, double most) {
    RequireInRange(fmt::format("{}: {}", kName, field), value, least, most);
  };
  require_one("soft_start in s", ToSeconds(soft_start), 0, 10);
  require_one("start_tolerance_rad", start_tolerance_rad, 1e-9, 0.1);
  require_one("settled_distance_rad", settled_distance_rad, 1e-9, 1);
  require_one("settled_speed_rad_per_s", settled_speed_rad_per_s, 1e-9, 1);
  require_one("settling_time in s", ToSeconds(settling_time), 0, 60);
}

JointTrajectoryEffortController::JointTrajectoryEffortController(
    reference::Trajectory trajectory, const JointTrajectoryEffortOptions& options)
    : trajectory_(std::move(trajectory)),
      options_(Validated(options)),
      soft_start_(options.soft_start) {}

void JointTrajectoryEffortController::Configure(control::ParameterReader& p) {
  using std::chrono::seconds;
  JointTrajectoryEffortOptions& o = options_;
  o.K_P = p.Joints("K_P", Dimension::kStiffness, o.K_P, 0, 1e4);
  o.K_I = p.Joints("K_I", Dimension::kIntegralGain, o.K_I, 0, 1e4);
  o.K_D = p.Joints("K_D", Dimension::kAngularDamping, o.K_D, 0, 1e3);
  o.integral_max = p.Joints("integral_max", Dimension::kTorque, o.integral_max, 0, 100);
  o.soft_start = p.Time("soft_start", o.soft_start, Duration::zero(), seconds(10));
  o.start_tolerance_rad =
      p.Quantity("start_tolerance", Dimension::kAngle, o.start_tolerance_rad, 1e-9, 0.1);
  o.path_tolerance = p.Joints("path_tolerance", Dimension::kAngle, o.path_tolerance, 0, 10);
  o.goal_tolerance = p.Joints("goal_tolerance", Dimension::kAngle, o.goal_tolerance, 0, 10);
  o.settled_distance_rad =
      p.Quantity("settled_distance", Dimension::kAngle, o.settled_distance_rad, 1e-9, 1);
  o.settled_speed_rad_per_s = p.Quantity("stopped_velocity_tolerance", Dimension::kAngularVelocity,
                                         o.settled_speed_rad_per_s, 1e-9, 1);
  o.settling_time = p.Time("goal_time", o.settling_time, Duration::zero(), seconds(60));
  o.Validate();
  soft_start_ = SoftStart(o.soft_start);
}

void JointTrajectoryEffortController::Activate(const RobotState& state, Time /*now*/) {
  is_running_ = false;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double first = trajectory_.start()[j];
    if (std::abs(state.q[j] - first) <= options_.start_tolerance_rad) continue;
    throw InputError(
        fmt::format("{}: joint {} of the robot is at {:.6f} rad, the trajectory starts at {:.6f} "
                    "rad; they may differ by {} rad. Move the robot to the first point, or let the "
                    "trajectory start where the robot is",
                    kName, j + 1, state.q[j], first, options_.start_tolerance_rad));
  }
}

void JointTrajectoryEffortController::Update(const RobotState& state, Time now,
                                             control::ControllerOutput& output) noexcept {
  if (is_running_ && breach_.of != Breach::Of::kNothing) {
    output.failed = true;
    return;
  }
  const bool is_first = !is_running_;
  if (is_first) Begin(now);
  const Duration elapsed = now - start_;
  output.target.joint = trajectory_.Sample(elapsed);
  JointVector tau = Law(output.target.joint, state, ToSeconds(now - last_));
  last_ = now;

  if (is_first) soft_start_.Begin(state, tau);
  soft_start_.AddTo(tau, elapsed);
  output.target.tau_J_d = tau;
  output.has_velocity = false;

  const Duration over = elapsed - trajectory_.duration();
  const bool out_of_time = over >= options_.settling_time;
  const bool is_settled = over >= Duration::zero() && IsSettled(state);
  if (over < Duration::zero()) {
    Judge(Breach::Of::kPath, options_.path_tolerance, output.target.joint.q, state, elapsed);
  } else if (out_of_time && !is_finished_ && !is_settled) {
    Judge(Breach::Of::kGoal, options_.goal_tolerance, trajectory_.goal(), state, elapsed);
  }
  output.failed = breach_.of != Breach::Of::kNothing;
  is_finished_ = is_finished_ || (!output.failed && (out_of_time || is_settled));
  output.finished = is_finished_;
}

void JointTrajectoryEffortController::Begin(Time now) noexcept {
  is_running_ = true;
  is_finished_ = false;
  breach_ = Breach();
  start_ = now;
  last_ = now;
  integral_ = JointVector{};
}

JointVector JointTrajectoryEffortController::Law(const reference::JointTarget& target,
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

bool JointTrajectoryEffortController::IsSettled(const RobotState& state) const noexcept {
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double tolerance = options_.goal_tolerance[j];
    const double near = tolerance > 0 ? std::min(tolerance, options_.settled_distance_rad)
                                      : options_.settled_distance_rad;
    const double distance = std::abs(trajectory_.goal()[j] - state.q[j]);
    if (!(distance <= near)) return false;
    if (!(std::abs(state.dq[j]) <= options_.settled_speed_rad_per_s)) return false;
  }
  return true;
}

void JointTrajectoryEffortController::Judge(Breach::Of of, const JointVector& tolerance,
                                            const JointVector& q_star, const RobotState& state,
                                            Duration elapsed) noexcept {
  for (std::size_t j = 0; j < kJoints; ++j) {
    const double distance = std::abs(q_star[j] - state.q[j]);
    if (tolerance[j] == 0 || distance <= tolerance[j]) continue;
    breach_ = {.of = of, .joint = j, .distance = distance, .at = elapsed};
    return;
  }
}

std::string JointTrajectoryEffortController::Explain() const {
  if (breach_.of == Breach::Of::kNothing) return {};
  const bool on_path = breach_.of == Breach::Of::kPath;
  const JointVector& tolerance = on_path ? options_.path_tolerance : options_.goal_tolerance;
  return fmt::format(
      "{}: joint {} was {:.4f} rad off the {} at {:.3f} s, and {} allows {:.4f} rad; {}", kName,
      breach_.joint + 1, breach_.distance, on_path ? "path" : "goal", ToSeconds(breach_.at),
      on_path ? "path_tolerance" : "goal_tolerance", tolerance[breach_.joint],
      on_path ? "see what held it, make the motion slower, or give a larger tolerance"
              : "see what held it, give it more goal_time or K_I, or a larger tolerance");
}

}  // namespace twin::controllers

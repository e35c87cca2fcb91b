#include "controllers/cartesian_pose.h"

#include <cmath>

#include <fmt/format.h>

#include "twin/core/joint_vector.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/model/transform.h"

namespace twin::controllers {
namespace {

constexpr double kArrived = 1e-5;      // m and rad
constexpr double kLimitMargin = 0.01;  // rad

/// Stopping distance of a joint from velocity dq, with the sign of dq, rad: the deceleration rises
/// to A and falls to zero at jerk J. An upper bound where |dq| < A^2/J.
double StoppingDistance(double dq, double A, double J) noexcept {
  return dq / 2 * (std::abs(dq) / A + A / J);
}

}  // namespace

CartesianPoseController::CartesianPoseController(const control::ControllerRequest& request,
                                                 const CartesianPoseOptions& options)
    : arm_(request.arm), limits_(request.limits), options_(options), reference_(request) {}

void CartesianPoseController::Configure(control::ParameterReader& p) {
  reference_.Configure(p);
  options_.K_P.fill(p.Quantity("K_P", Dimension::kRate, options_.K_P[0], 0, 100));
  options_.alpha = p.Number("alpha", options_.alpha, 0, 1);
  options_.goal_time =
      p.Time("goal_time", options_.goal_time, Duration::zero(), std::chrono::seconds(60));
}

void CartesianPoseController::Activate(const RobotState& state, Time now) {
  is_running_ = false;
  reference_.Begin(state.q_d, state.F_T_EE, now, "cartesian_pose");
}

void CartesianPoseController::Update(const RobotState& state, Time now,
                                     control::ControllerOutput& output) noexcept {
  if (!is_running_) {
    is_running_ = true;
    is_finished_ = false;
    failure_ = Failure::kNone;
    start_ = now;
    elapsed_ = Duration::zero();
    q_c_ = state.q_d;
    dq_c_ = {};
  }
  const Duration elapsed = now - start_;
  if (elapsed > elapsed_ && failure_ == Failure::kNone && !is_finished_) {
    Step(elapsed_, elapsed);
    elapsed_ = elapsed;
  }
  output.target.joint = {.q = q_c_, .dq = dq_c_, .ddq = {}};
  output.target.pose = reference_.Sample(elapsed);
  output.has_velocity = true;
  output.failed = failure_ != Failure::kNone;
  output.finished = is_finished_;
}

void CartesianPoseController::Step(Duration from, Duration to) noexcept {
  const model::FrameMotion motion =
      arm_.MotionOf(model::Frame::kEndEffector, q_c_, reference_.F_T_EE());
  const Vector6 e = model::WayTo(motion.O_T_frame, reference_.Sample(from).O_T_EE);
  const bool is_over = from >= reference_.duration();
  if (is_over && HalfNorm(e, 0) <= kArrived && HalfNorm(e, 3) <= kArrived) {
    dq_c_ = {};
    is_finished_ = true;
    return;
  }
  if (is_over && from > reference_.duration() + options_.goal_time) {
    Fail(Failure::kGoal, 0, HalfNorm(e, 0), from);
    return;
  }
  Vector6 v = reference_.Sample(from + (to - from) / 2).O_dP_EE;
  for (std::size_t i = 0; i < v.size(); ++i) v[i] += options_.K_P[i] * e[i];
  const JointVector dq = model::DampedLeastSquares(motion.J, v, options_.alpha);
  JointVector q = q_c_;
  for (std::size_t j = 0; j < kJoints; ++j) {
    q[j] += dq[j] * ToSeconds(to - from);
    if (!(std::abs(dq[j]) <= limits_.dq_max[j])) return Fail(Failure::kVelocity, j, dq[j], to);
    const double at_rest = q[j] + StoppingDistance(dq[j], limits_.ddq_max[j], limits_.dddq_max[j]);
    if (!IsInRange(j, q[j])) return Fail(Failure::kPosition, j, q[j], to);
    if (!IsInRange(j, at_rest)) return Fail(Failure::kPosition, j, at_rest, to);
  }
  q_c_ = q;
  dq_c_ = dq;
}

bool CartesianPoseController::IsInRange(std::size_t joint, double q) const noexcept {
  return q >= limits_.q_min[joint] + kLimitMargin && q <= limits_.q_max[joint] - kLimitMargin;
}

void CartesianPoseController::Fail(Failure failure, std::size_t joint, double value,
                                   Duration at) noexcept {
  failure_ = failure;
  failed_joint_ = joint;
  failed_value_ = value;
  failed_at_ = at;
  dq_c_ = {};
}

std::string CartesianPoseController::Explain() const {
  const std::size_t j = failed_joint_;
  const double at = ToSeconds(failed_at_);
  switch (failure_) {
    case Failure::kNone: break;
    case Failure::kVelocity:
      return fmt::format(
          "cartesian_pose: at {:.3f} s joint {} would have to move at {:.3f} rad/s, its limit is "
          "{:.3f} rad/s: the path is too fast, or near a singularity; make it slower or lead it "
          "elsewhere",
          at, j + 1, failed_value_, limits_.dq_max[j]);
    case Failure::kPosition:
      return fmt::format(
          "cartesian_pose: at {:.3f} s joint {} can stop at {:.4f} rad at the earliest, {} rad "
          "short of the end of its range [{:.4f}, {:.4f}] rad or beyond; lead the path elsewhere, "
          "or begin it with another configuration of the arm",
          at, j + 1, failed_value_, kLimitMargin, limits_.q_min[j], limits_.q_max[j]);
    case Failure::kGoal:
      return fmt::format(
          "cartesian_pose: the goal is not reached {:.3f} s after the path's end: {:.5f} m are "
          "left; "
          "is it out of reach? Else give more goal_time, or a larger K_P",
          ToSeconds(options_.goal_time), failed_value_);
  }
  return {};
}

}  // namespace twin::controllers

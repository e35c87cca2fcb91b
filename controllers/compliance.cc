#include "controllers/compliance.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::controllers {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using EigenVector6 = Eigen::Matrix<double, 6, 1>;
using EigenVector7 = Eigen::Matrix<double, 7, 1>;
using ConstJacobian = Eigen::Map<const Eigen::Matrix<double, 6, 7>>;

// m^2, rad^2
constexpr double kDamping = 1e-6;
constexpr double kDampingOfPosture = 1e-2;

Eigen::Map<const EigenVector7> AsEigen(const JointVector& v) {
  return Eigen::Map<const EigenVector7>(v.data());
}

Eigen::Map<const EigenVector6> AsEigen(const Vector6& v) {
  return Eigen::Map<const EigenVector6>(v.data());
}

/// (I - J^T (J J^T + d I)^-1 J) tau_0.
EigenVector7 ToNullSpace(const ConstJacobian& J, const EigenVector7& tau_0, double d) {
  const Matrix6 A = J * J.transpose() + d * Matrix6::Identity();
  const EigenVector6 y = A.ldlt().solve(J * tau_0);
  return tau_0 - J.transpose() * y;
}

/// Reads two parameters of three axes each.
Vector6 Axes(control::ParameterReader& p, const std::string& key, Dimension translation,
             Dimension rotation, const Vector6& otherwise, double most_along, double most_about) {
  const Vector3 along = p.Vector(key + ".translation", translation,
                                 {otherwise[0], otherwise[1], otherwise[2]}, 0, most_along);
  const Vector3 about = p.Vector(key + ".rotation", rotation,
                                 {otherwise[3], otherwise[4], otherwise[5]}, 0, most_about);
  return {along[0], along[1], along[2], about[0], about[1], about[2]};
}

}  // namespace

ComplianceController::ComplianceController(const control::ControllerRequest& request,
                                           const ComplianceOptions& options)
    : arm_(request.arm),
      friction_left_(1 - request.friction_compensated),
      options_(options),
      reference_(request),
      soft_start_(options.soft_start) {}

void ComplianceController::Configure(control::ParameterReader& p) {
  using std::chrono::seconds;
  ComplianceOptions& o = options_;
  reference_.Configure(p, true);
  o.K_P =
      Axes(p, "stiffness", Dimension::kLinearStiffness, Dimension::kStiffness, o.K_P, 5000, 500);
  o.K_D =
      Axes(p, "damping", Dimension::kLinearDamping, Dimension::kAngularDamping, o.K_D, 1000, 100);
  o.k_0 = p.Quantity("k0", Dimension::kStiffness, o.k_0, 0, 100);
  o.q_0 = p.Joints("q0", Dimension::kAngle, o.q_0, -10, 10);
  o.coriolis = p.Bool("coriolis_compensation", o.coriolis);
  const double share = p.Number("friction_compensation", o.friction.value_or(friction_left_), 0, 1);
  constexpr double kRounding = 1e-12;
  if (share > friction_left_ + kRounding) {
    p.Refuse(
        "friction_compensation",
        fmt::format("{} and the {} of the robot (onboard.friction_compensation) are more than 1; "
                    "friction would be made up for twice: give at most {}, or leave it out",
                    share, 1 - friction_left_, friction_left_));
  }
  o.friction = share;
  o.soft_start = p.Time("soft_start", o.soft_start, Duration::zero(), seconds(10));
  o.settling_time = p.Time("settling_time", o.settling_time, Duration::zero(), seconds(60));
  soft_start_ = SoftStart(o.soft_start);
}

void ComplianceController::Activate(const RobotState& state, Time now) {
  is_running_ = false;
  over_.reset();
  reference_.Begin(state.q, state.F_T_EE, now, "compliance");
  payload_ = model::Combine({state.m_ee, state.F_x_Cee, state.I_ee},
                            {state.m_load, state.F_x_Cload, state.I_load});
}

void ComplianceController::Update(const RobotState& state, Time now,
                                  control::ControllerOutput& output) noexcept {
  const bool is_first = !is_running_;
  if (is_first) start_ = now;
  is_running_ = true;
  const Duration elapsed = now - start_;
  output.target.pose = reference_.Next(state, now, elapsed);
  output.target.joint = {.q = state.q, .dq = state.dq, .ddq = {}};
  JointVector tau = Law(state, output.target.pose);
  if (is_first) soft_start_.Begin(state, tau);
  soft_start_.AddTo(tau, elapsed);
  output.target.tau_J_d = tau;
  output.has_velocity = false;
  output.failed = false;
  if (!over_ && reference_.IsOver(elapsed)) over_ = std::min(elapsed, reference_.duration());
  output.finished = over_ && elapsed >= *over_ + options_.settling_time;
}

JointVector ComplianceController::Law(const RobotState& state,
                                      const reference::PoseTarget& target) const noexcept {
  const model::Configuration q(state.q);
  const model::FrameMotion motion =
      arm_.MotionOf(model::Frame::kEndEffector, q, reference_.F_T_EE());
  const ConstJacobian J(motion.J.data());
  const auto dq = AsEigen(state.dq);

  const Vector6 e = model::WayTo(motion.O_T_frame, target.O_T_EE);
  const EigenVector6 de = AsEigen(target.O_dP_EE) - J * dq;
  const EigenVector6 F =
      AsEigen(options_.K_P).cwiseProduct(AsEigen(e)) + AsEigen(options_.K_D).cwiseProduct(de);
  const std::optional<reference::JointTarget> led = reference_.posture();
  const reference::JointTarget posture = led.value_or(reference::JointTarget{.q = options_.q_0});
  const EigenVector7 tau_0 = options_.k_0 * (AsEigen(posture.q) - AsEigen(state.q)) +
                             2 * std::sqrt(options_.k_0) * (AsEigen(posture.dq) - dq);

  JointVector tau;
  Eigen::Map<EigenVector7> sum(tau.data());
  sum = J.transpose() * F + ToNullSpace(J, tau_0, led ? kDampingOfPosture : kDamping);
  if (options_.coriolis) sum += AsEigen(arm_.Coriolis(q, state.dq, payload_));
  const double friction = options_.friction.value_or(friction_left_);
  if (friction > 0) sum += friction * AsEigen(model::ResidualFriction(state.dq));
  return tau;
}

}  // namespace twin::controllers

#include "conformance/measured_oracle.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <Eigen/Core>

#include "conformance/arm_oracle.h"
#include "conformance/pose_math.h"
#include "support/dense.h"

namespace twin::test {
namespace {

/// From when on a reference accelerates, rad/s^2.
constexpr double kAccelerates = 1e-6;

bool Accelerates(const RobotState& s) {
  return std::any_of(s.ddq_d.begin(), s.ddq_d.end(),
                     [](double a) { return std::abs(a) > kAccelerates; });
}

template <std::size_t N>
Quantity Above(RobotError error, const std::array<double, N>& value,
               const std::array<double, N>& upper) {
  Quantity quantity;
  quantity.error = error;
  quantity.size = N;
  for (std::size_t i = 0; i < N; ++i) {
    quantity.value[i] = value[i];
    quantity.low[i] = -upper[i];
    quantity.high[i] = upper[i];
  }
  return quantity;
}

template <std::size_t N>
std::optional<std::string> FindWrong(const char* name, const std::array<double, N>& flags,
                                     const std::array<double, N>& latched,
                                     const std::array<double, N>& values,
                                     const std::array<double, N>& thresholds) {
  const Quantity quantity = Above(RobotError{}, values, thresholds);
  for (std::size_t i = 0; i < N; ++i) {
    const bool may = latched[i] != 0 || quantity.MayBreak(i);
    const bool must = latched[i] != 0 || quantity.MustBreak(i);
    if (flags[i] == 1 ? may : flags[i] == 0 && !must) continue;
    return fmt::format("{}[{}] is {} at {:.17g}, threshold {}, before {}", name, i, flags[i],
                       values[i], thresholds[i], latched[i]);
  }
  return {};
}

using Jacobian = std::array<Vector6, kJoints>;

/// |J tau|.
double Norm6(const Jacobian& J, const JointVector& tau) {
  double sum = 0;
  for (std::size_t r = 0; r < 6; ++r) {
    double x = 0;
    for (std::size_t j = 0; j < kJoints; ++j) x += J[j][r] * tau[j];
    sum += x * x;
  }
  return std::sqrt(sum);
}

}  // namespace

Verdict JudgeCollisions(const RobotState& last, const setting::CollisionBehavior& behavior) {
  const bool acc = Accelerates(last);
  Verdict verdict;
  verdict.Examine(Above(RobotError::kJointReflex, last.tau_ext_hat_filtered,
                        acc ? behavior.upper_torque_acc : behavior.upper_torque_nominal));
  verdict.Examine(Above(RobotError::kCartesianReflex, last.K_F_ext_hat_K,
                        acc ? behavior.upper_force_acc : behavior.upper_force_nominal));
  return verdict;
}

Verdict JudgeMeasured(const RobotState& last, const MeasuredLimits& limits, bool is_cartesian) {
  const ArmOracle arm(last.q);
  Verdict verdict;
  verdict.Examine(
      {RobotError::kJointPositionLimitsViolation, kJoints, last.q, limits.q_min, limits.q_max, 0});
  verdict.Examine(Magnitudes(RobotError::kJointVelocityViolation, last.dq, limits.dq_max, 0));
  verdict.Examine(Magnitudes(RobotError::kTauJRangeViolation, last.tau_J, limits.tau_J_max, 0));

  const Vector6 twist = arm.Twist(last.dq, last.F_T_EE);
  Quantity speed;
  speed.error = RobotError::kCartesianVelocityViolation;
  speed.size = is_cartesian ? 2 : 1;
  speed.value = {Norm(Linear(twist)), Norm(Angular(twist))};
  speed.low = {-1, -1};
  speed.high = {limits.translation_max, limits.rotation_max};
  speed.noise = 1e-12;
  verdict.Examine(speed);

  const JointVector g = arm.Gravity({{last.m_ee, last.F_x_Cee}, {last.m_load, last.F_x_Cload}});
  Quantity power;
  power.error = RobotError::kPowerLimitViolation;
  power.size = 1;
  for (std::size_t i = 0; i < kJoints; ++i) {
    power.value[0] += (last.tau_J_d[i] + g[i]) * last.dq[i];
  }
  power.low = {-1e9};
  power.high = {limits.power_max};
  power.noise = 1e-9;
  verdict.Examine(power);
  return verdict;
}

Verdict JudgeSelfCollision(const RobotState& last, const MeasuredLimits& limits) {
  Quantity distance;
  distance.error = RobotError::kSelfCollisionAvoidanceViolation;
  distance.size = 1;
  distance.value = {ArmOracle(last.q).SelfDistance(limits.has_hand)};
  distance.low = {limits.clearance};
  distance.high = {1e9};
  distance.noise = 1e-10;
  Verdict verdict;
  verdict.Examine(distance);
  return verdict;
}

bool IsOutOfRange(const JointVector& q, const MeasuredLimits& limits) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (q[i] < limits.q_min[i] || q[i] > limits.q_max[i]) return true;
  }
  return false;
}

std::optional<std::string> FindWrongFlags(const RobotState& before, const RobotState& s,
                                          const setting::CollisionBehavior& b) {
  const bool acc = Accelerates(s);
  const JointVector no_joint{};
  const Vector6 none{};
  if (auto found = FindWrong("joint_contact", s.joint_contact, no_joint, s.tau_ext_hat_filtered,
                             acc ? b.lower_torque_acc : b.lower_torque_nominal)) {
    return found;
  }
  if (auto found = FindWrong("cartesian_contact", s.cartesian_contact, none, s.K_F_ext_hat_K,
                             acc ? b.lower_force_acc : b.lower_force_nominal)) {
    return found;
  }
  if (auto found =
          FindWrong("joint_collision", s.joint_collision, before.joint_collision,
                    s.tau_ext_hat_filtered, acc ? b.upper_torque_acc : b.upper_torque_nominal)) {
    return found;
  }
  return FindWrong("cartesian_collision", s.cartesian_collision, before.cartesian_collision,
                   s.K_F_ext_hat_K, acc ? b.upper_force_acc : b.upper_force_nominal);
}

namespace {

/// What is told of the external force: all of it where an error of the joints' torques arrives
/// enlarged by less than 16, nothing from 20 on: sqrt(sum 1/sigma_i^2), sigma_i the
/// singular values of EE's Jacobian.
double WrenchShare(const RobotState& s) {
  const Jacobian columns = ArmOracle(s.q).Jacobian(s.F_T_EE);
  Eigen::Matrix<double, 6, kJoints> J;
  for (std::size_t j = 0; j < kJoints; ++j) {
    J.col(static_cast<Eigen::Index>(j)) =
        Eigen::Map<const Eigen::Matrix<double, 6, 1>>(columns[j].data());
  }
  const double gain_squared = SingularValues(J).cwiseInverse().squaredNorm();
  return std::clamp((20.0 * 20 - gain_squared) / (20.0 * 20 - 16.0 * 16), 0.0, 1.0);
}

}  // namespace

std::optional<std::string> FindWrongWrench(const RobotState& s) {
  const Transform F_T_K = Product(s.F_T_EE, s.EE_T_K);
  const ArmOracle arm(s.q);
  const Jacobian J = arm.Jacobian(F_T_K);
  const Transform O_T_K = arm.Pose(F_T_K);
  const Vector6& F = s.O_F_ext_hat_K;
  for (std::size_t block = 0; block < 2; ++block) {
    for (std::size_t c = 0; c < 3; ++c) {
      double in_K = 0;
      for (std::size_t r = 0; r < 3; ++r) in_K += O_T_K[4 * c + r] * F[3 * block + r];
      if (std::abs(in_K - s.K_F_ext_hat_K[3 * block + c]) <= 1e-9 * (1 + std::abs(in_K))) continue;
      return fmt::format("K_F_ext_hat_K[{}] is not O_F_ext_hat_K in K axes", 3 * block + c);
    }
  }
  const double share = WrenchShare(s);
  if (F == Vector6{}) {
    const bool has_reason = Norm6(J, s.tau_ext_hat_filtered) < 1e-12 || share < 1e-9;
    return has_reason ? std::nullopt : std::optional<std::string>("no external force is told");
  }
  JointVector left = s.tau_ext_hat_filtered;
  for (double& tau : left) tau *= share;
  for (std::size_t j = 0; j < kJoints; ++j) {
    for (std::size_t r = 0; r < 6; ++r) left[j] -= J[j][r] * F[r];
  }
  const double off = Norm6(J, left);
  if (off <= 1e-9 * (1 + Norm6(J, s.tau_ext_hat_filtered))) return {};
  return fmt::format("O_F_ext_hat_K leaves {} of the external torque", off);
}

}  // namespace twin::test

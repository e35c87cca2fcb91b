#include "twin/teleop/posture_guard.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace twin::teleop {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using ConstJacobian = Eigen::Map<const Eigen::Matrix<double, 6, 7>>;

constexpr double kAhead = 0.25;         // s
constexpr double kFarthestAhead = 0.1;  // rad: bounds the prediction near a singular posture
constexpr double kDamping = 1e-4;       // m^2, rad^2
constexpr double kWorthIt = 1e-6;       // norm of a twist; smaller twists count as rest

/// sqrt(det(J J^T)).
double Manipulability(const ConstJacobian& J) {
  const Matrix6 A = J * J.transpose();
  return std::sqrt(std::max(0.0, A.ldlt().vectorD().prod()));
}

/// Share that a falling measure permits.
double Through(double now, double then, double hard, double soft) {
  if (then >= now || now >= soft) return 1;
  return std::clamp((now - hard) / (soft - hard), 0.0, 1.0);
}

}  // namespace

double PostureGuard::Share(const RobotState& state, const Vector6& twist) const noexcept {
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> u(twist.data());
  if (u.norm() < kWorthIt) return 1;
  const model::Jacobian here = arm_.ZeroJacobian(model::Frame::kEndEffector, state.q, state.F_T_EE);
  const ConstJacobian J(here.data());
  const Matrix6 A = J * J.transpose() + kDamping * Matrix6::Identity();
  const Eigen::Matrix<double, 7, 1> dq = J.transpose() * A.ldlt().solve(u);
  const double ahead = std::min(kAhead, kFarthestAhead / dq.lpNorm<Eigen::Infinity>());
  JointVector q = state.q;
  double share = 1;
  for (std::size_t i = 0; i < kJoints; ++i) {
    q[i] += ahead * dq[static_cast<Eigen::Index>(i)];
    const auto margin = [&](double at) {
      return std::min(at - limits_.q_min[i], limits_.q_max[i] - at);
    };
    share = std::min(share, Through(margin(state.q[i]), margin(q[i]), kHardMargin, kSoftMargin));
  }
  const model::Jacobian there = arm_.ZeroJacobian(model::Frame::kEndEffector, q, state.F_T_EE);
  return std::min(share, Through(Manipulability(J), Manipulability(ConstJacobian(there.data())),
                                 kHardManipulability, kSoftManipulability));
}

}  // namespace twin::teleop

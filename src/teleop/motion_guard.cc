#include "twin/teleop/motion_guard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "twin/model/self_collision.h"
#include "twin/model/transform.h"

namespace twin::teleop {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Inverse = Eigen::Matrix<double, 7, 6>;  // B
using Row6 = Eigen::Matrix<double, 1, 6>;
using ConstJacobian = Eigen::Map<const Eigen::Matrix<double, 6, 7>>;
using Joints = Eigen::Matrix<double, 7, 1>;
using ConstTwist = Eigen::Map<const Eigen::Matrix<double, 6, 1>>;
using ConstJoints = Eigen::Map<const Eigen::Matrix<double, 7, 1>>;

constexpr double kDamping = 1e-4;  // m^2, rad^2
constexpr double kStep = 1e-4;     // rad, of numerical derivatives
// Speed back from a bound. A joint's outweighs what it drifts outwards while its bound turns: the
// twist follows the allowed one with a delay.
constexpr double kBack = 0.05;      // m/s
constexpr double kJointBack = 0.1;  // rad/s
constexpr double kWeak = 0.2;       // singular values above bound nothing
constexpr double kNoSigma = 1e-9;

/// The smallest singular value of J, and its singular vectors.
struct Weakest {
  double sigma;
  Eigen::Matrix<double, 6, 1> u;
  Eigen::Matrix<double, 7, 1> v;
};

Weakest WeakestOf(const ConstJacobian& J) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(J * J.transpose());
  const double sigma = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  const Eigen::Matrix<double, 6, 1> u = solver.eigenvectors().col(0);
  return {sigma, u, J.transpose() * u / std::max(sigma, kNoSigma)};
}

/// Posture, kAhead later along its motion.
JointVector AheadOf(const reference::JointTarget& posture) {
  JointVector q = posture.q;
  for (std::size_t i = 0; i < kJoints; ++i) q[i] += MotionGuard::kAhead * posture.dq[i];
  return q;
}

/// dh/dq by differences.
template <typename Measure>
Joints Gradient(const Measure& h, double here, const JointVector& q) {
  Joints gradient;
  for (std::size_t i = 0; i < kJoints; ++i) {
    JointVector there = q;
    there[i] += kStep;
    gradient[static_cast<Eigen::Index>(i)] = (h(there) - here) / kStep;
  }
  return gradient;
}

}  // namespace

template <typename Keep>
void MotionGuard::Measure(const JointVector& q, const model::Jacobian& J, const RobotState& state,
                          const BasePose& base, const Keep& keep) noexcept {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Joints axis = Joints::Unit(static_cast<Eigen::Index>(i));
    double fastest = kJointSpeedShare * limits_.dq_max[i];
    if (lab_.dq_max) fastest = std::min(fastest, kCapShare * (*lab_.dq_max)[i]);
    const auto keep_from = [&](double margin, const Joints& gradient) {
      const double h = margin - kJointMargin;
      const Bound bound = kDecay * h < fastest ? Bound::kJointEnd : Bound::kJointSpeed;
      keep(h, gradient, {bound, static_cast<std::uint8_t>(i + 1)}, fastest);
    };
    keep_from(limits_.q_max[i] - std::max(q[i], state.q[i]), -axis);
    keep_from(std::min(q[i], state.q[i]) - limits_.q_min[i], axis);
  }

  const Weakest weakest = WeakestOf(ConstJacobian(J.data()));
  if (weakest.sigma < kWeak) {
    const auto at = [&](const JointVector& there) {
      const model::Jacobian moved =
          arm_.ZeroJacobian(model::Frame::kEndEffector, there, state.F_T_EE);
      return weakest.u.dot(ConstJacobian(moved.data()) * weakest.v);
    };
    keep(weakest.sigma - kLeastSingular, Gradient(at, weakest.sigma, q), {Bound::kSingular}, kAny);
  }

  const double apart = model::SelfDistance(q, with_hand_, kHorizon);
  if (apart < kHorizon) {
    const auto at = [&](const JointVector& there) {
      return model::SelfDistance(there, with_hand_);
    };
    keep(apart - kSelfMargin, Gradient(at, apart, q), {Bound::kSelf}, kAny);
  }

  std::array<model::RegionMargin, kMostPlanes> planes;
  const std::size_t found =
      model::MarginsWithin(kHorizon, lab_, {state.F_T_EE, with_hand_}, q, planes);
  for (const model::RegionMargin& plane : std::span(planes).first(found)) {
    ActiveBound bound{Bound::kRegion};
    lab_.regions[plane.region].name.copy(bound.region.data(), bound.region.size() - 1);
    keep(plane.margin - kRegionMargin, ConstJoints(plane.gradient.data()), bound, kAny);
  }

  if (lab_.force_max) {
    const Eigen::Vector3d pushed = model::Linear(state.O_F_ext_hat_K);
    const double left = *lab_.force_max - pushed.norm();
    if (left < *lab_.force_max / 2) {
      const Joints along = ConstJacobian(J.data()).topRows<3>().transpose() * pushed.normalized();
      keep(left / kStiffest, -along, {Bound::kForce}, kAny);
    }
  }
  for (std::size_t i = 0; lab_.tau_max && i < kJoints; ++i) {
    const double pushed = state.tau_ext_hat_filtered[i];
    const double left = (*lab_.tau_max)[i] - std::abs(pushed);
    if (left >= (*lab_.tau_max)[i] / 2) continue;
    const Joints axis = Joints::Unit(static_cast<Eigen::Index>(i));
    keep(left / kStiffestJoint, -std::copysign(1.0, pushed) * axis,
         {Bound::kTorque, static_cast<std::uint8_t>(i + 1)}, kAny);
  }

  if (surroundings_ == nullptr) return;
  std::array<Obstacle, kMostObstacles> near;
  const std::size_t count = surroundings_->Near(q, base, kHorizon, near);
  for (std::size_t k = 0; k < count; ++k) {
    keep(near[k].distance - kSceneMargin, ConstJoints(near[k].gradient.data()), {Bound::kScene},
         kAny);
  }
}

void MotionGuard::AddTo(TwistBounds& bounds, const reference::JointTarget& posture,
                        const Vector6& twist, const RobotState& state,
                        const BasePose& base) noexcept {
  const JointVector q = AheadOf(posture);
  const model::Jacobian here = arm_.ZeroJacobian(model::Frame::kEndEffector, q, state.F_T_EE);
  const ConstJacobian J(here.data());
  const Matrix6 A = J * J.transpose() + kDamping * Matrix6::Identity();
  const Inverse B = J.transpose() * A.ldlt().solve(Matrix6::Identity());
  const Joints dq_0 = ConstJoints(posture.dq.data()) - B * ConstTwist(twist.data());
  /// Keeps the measure h with this gradient from falling by more than `fastest` per second.
  const auto keep = [&](double h, const Joints& gradient, ActiveBound bound, double fastest) {
    Vector6 row;
    Eigen::Map<Row6>(row.data()) = -gradient.transpose() * B;
    const double back = bound.joint != 0 ? kJointBack : kBack;
    const double falling = std::clamp(kDecay * h, -back, fastest);
    bounds.Add(row, falling + gradient.dot(dq_0), bound);
  };
  Measure(q, here, state, base, keep);
}

void MotionGuard::AddTo(TurnBounds& bounds, std::size_t joint,
                        const reference::JointTarget& posture, const RobotState& state,
                        const BasePose& base) noexcept {
  const JointVector q = AheadOf(posture);
  const auto keep = [&](double h, const Joints& gradient, ActiveBound bound, double fastest) {
    bounds.Add(-gradient[static_cast<Eigen::Index>(joint)], std::min(kDecay * h, fastest), bound);
  };
  const model::Jacobian J = arm_.ZeroJacobian(model::Frame::kEndEffector, q, state.F_T_EE);
  const auto column = ConstJacobian(J.data()).col(static_cast<Eigen::Index>(joint));
  const auto cap = [&](double radius, std::optional<double> fastest) {
    if (!fastest) return;
    const ActiveBound bound{Bound::kJointSpeed, static_cast<std::uint8_t>(joint + 1)};
    bounds.Add(radius, kCapShare * *fastest, bound);
    bounds.Add(-radius, kCapShare * *fastest, bound);
  };
  cap(column.head<3>().norm(), lab_.v_max);
  cap(column.tail<3>().norm(), lab_.w_max);
  Measure(q, J, state, base, keep);
}

}  // namespace twin::teleop

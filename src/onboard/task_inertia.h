#pragma once

#include <Eigen/Core>

#include "onboard/factors.h"
#include "twin/core/joint_vector.h"
#include "twin/model/arm_model.h"

namespace twin::onboard::internal {

using JointColumn = Eigen::Matrix<double, kJoints, 1>;
using JointSquare = Factors<kJoints>::Square;

inline Eigen::Map<const JointColumn> Column(const JointVector& v) noexcept {
  return Eigen::Map<const JointColumn>(v.data());
}

/// M(q) + B, the inertia that the drives accelerate.
inline JointSquare InertiaWithRotors(const model::ArmModel& arm, const model::Configuration& q,
                                     const model::Payload& payload,
                                     const JointVector& rotor_inertia) noexcept {
  const model::JointMatrix M = arm.MassMatrix(q, payload);
  JointSquare with_rotors = Eigen::Map<const JointSquare>(M.data());
  with_rotors.diagonal() += Column(rotor_inertia);
  return with_rotors;
}

/// The inertia of a task whose velocity is J dq:
///   Lambda = (J M^-1 J^T + E)^-1,
/// E diagonal: an axis along which the arm cannot move has inertia 1 / E, not infinity.
///
/// Real-time: noexcept, allocates nothing.
template <int n>
class TaskInertia {
 public:
  using Task = Eigen::Matrix<double, n, 1>;
  using TaskJacobian = Eigen::Matrix<double, n, kJoints>;

  /// @param M  positive definite. @param E  each > 0.
  TaskInertia(const JointSquare& M, const TaskJacobian& J, const Task& E) noexcept
      : M_(M), G_(Reduce(J)), Lambda_(Mobility(E)) {}

  /// Lambda_ii: inertia of each axis alone, with the others held.
  [[nodiscard]] Task Diagonal() const noexcept { return Lambda_.Diagonal(); }

  /// Lambda J M^-1 tau: the task force with the same effect on the task as the torque.
  [[nodiscard]] Task ForceOf(const JointColumn& tau) const noexcept {
    return Lambda_.Times(AccelerationOf(tau));
  }

  /// The same without directions of low mobility: an axis of mobility l = 1 / inertia gets the
  /// share 1 - (E / (l + E))^3, which is 1 where l is well above E and 0 where it is well below.
  /// With Lambda of this E, it is f_3 of f_1 = Lambda a, f_(k+1) = f_1 + Lambda E f_k.
  [[nodiscard]] Task MovableForceOf(const JointColumn& tau, const Task& E) const noexcept {
    const Inverse<n> Lambda(Mobility(E));
    const Task first = Lambda.Times(AccelerationOf(tau));
    const Task second = first + Lambda.Times(E.cwiseProduct(first));
    return first + Lambda.Times(E.cwiseProduct(second));
  }

 private:
  static constexpr int kColumns = static_cast<int>(kJoints);
  using Square = typename Factors<n>::Square;

  /// J L^-T: J M^-1 J^T = G diag(d) G^T.
  [[nodiscard]] TaskJacobian Reduce(const TaskJacobian& J) const noexcept {
    TaskJacobian G;
    TWIN_UNROLL
    for (int k = 0; k < kColumns; ++k) {
      Task column = J.col(k);
      TWIN_UNROLL
      for (int j = 0; j < k; ++j) column -= M_.L(k, j) * G.col(j);
      G.col(k) = column;
    }
    return G;
  }

  /// J M^-1 J^T + E, by columns, which equal its rows.
  [[nodiscard]] Square Mobility(const Task& E) const noexcept {
    Square A;
    TWIN_UNROLL
    for (int row = 0; row < n; ++row) {
      Task sum = Task::Zero();
      TWIN_UNROLL
      for (int k = 0; k < kColumns; ++k) sum += M_.d[k] * G_(row, k) * G_.col(k);
      A.row(row) = sum.transpose();
    }
    A.diagonal() += E;
    return A;
  }

  /// J M^-1 tau.
  [[nodiscard]] Task AccelerationOf(const JointColumn& tau) const noexcept {
    JointColumn reduced = tau;
    Task acceleration = Task::Zero();
    TWIN_UNROLL
    for (int k = 0; k < kColumns; ++k) {
      TWIN_UNROLL
      for (int j = 0; j < k; ++j) reduced[k] -= M_.L(k, j) * reduced[j];
      acceleration += M_.d[k] * reduced[k] * G_.col(k);
    }
    return acceleration;
  }

  Factors<kJoints> M_;
  TaskJacobian G_;
  Inverse<n> Lambda_;
};

}  // namespace twin::onboard::internal

#include "twin/onboard/cartesian_impedance.h"

#include <cmath>

#include "onboard/task_inertia.h"
#include "twin/model/transform.h"

namespace twin::onboard {
namespace {

using internal::Column;
using internal::JointColumn;
using internal::JointSquare;
using TaskInertia = internal::TaskInertia<6>;
using Task = TaskInertia::Task;

constexpr double kNullStiffness = 200;  // Nm/rad

/// Largest inertia of an axis with critical damping, kg and kg m^2.
const Task kHeaviestDamped = (Task() << 50, 50, 50, 5, 5, 5).finished();
/// Inverse of the largest inertia of an axis, 1/kg and 1/(kg m^2).
const Task kRegularisation = (Task() << 1e-6, 1e-6, 1e-6, 1e-5, 1e-5, 1e-5).finished();
/// Mobility below which, near a singularity, an axis of K counts as immovable.
const Task kImmovable = (Task() << 5e-3, 5e-3, 5e-3, 5e-2, 5e-2, 5e-2).finished();
/// Times kHeaviestDamped: the inertia above which the arm is near a singularity.
constexpr double kNearSingular = 2;

/// Part of tau that would act on K, with a share of kImmovable that grows towards a singularity.
Task TaskForce(const TaskInertia& inertia, const Task& diagonal, const JointColumn& tau) noexcept {
  const double heaviest = diagonal.cwiseQuotient(kHeaviestDamped).maxCoeff();
  if (heaviest <= kNearSingular) return inertia.ForceOf(tau);
  return inertia.MovableForceOf(tau, kRegularisation + (1 - kNearSingular / heaviest) * kImmovable);
}

/// Rotation vector of R by sine and cosine, for angles below a quarter turn; costs half as much as
/// by a quaternion.
Eigen::Vector3d RotationVector(const Eigen::Matrix3d& R) noexcept {
  const double cosine = 0.5 * (R.trace() - 1);
  if (!(cosine > 0)) return model::Log(Eigen::Quaterniond(R));
  const Eigen::Vector3d axis =
      0.5 * Eigen::Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double sine = axis.norm();
  return sine > 0 ? Eigen::Vector3d(std::atan2(sine, cosine) / sine * axis) : axis;
}

/// The body Jacobian of K, which is fixed to EE.
TaskInertia::TaskJacobian JacobianAt(const Transform& O_T_K,
                                     const model::FrameMotion& EE) noexcept {
  const Eigen::Map<const TaskInertia::TaskJacobian> J_EE(EE.J.data());
  const Eigen::Matrix3d K_R_O =
      Eigen::Map<const Eigen::Matrix4d>(O_T_K.data()).topLeftCorner<3, 3>().transpose();
  const Eigen::Vector3d lever = model::Position(O_T_K) - model::Position(EE.O_T_frame);
  TaskInertia::TaskJacobian J;
  for (int joint = 0; joint < static_cast<int>(kJoints); ++joint) {
    const Eigen::Vector3d w = J_EE.block<3, 1>(3, joint);
    J.block<3, 1>(0, joint) = K_R_O * (J_EE.block<3, 1>(0, joint) + w.cross(lever));
    J.block<3, 1>(3, joint) = K_R_O * w;
  }
  return J;
}

/// From pose X to pose X_d: translation and rotation in the axes of X.
Task Error(const Transform& X, const Transform& X_d) noexcept {
  const Transform X_XXd = model::Multiply(model::Inverse(X), X_d);
  Task e;
  e.head<3>() = model::Position(X_XXd);
  e.tail<3>() =
      RotationVector(Eigen::Map<const Eigen::Matrix4d>(X_XXd.data()).topLeftCorner<3, 3>());
  return e;
}

}  // namespace

ImpedanceTorque CartesianImpedance::Torque(const JointReference& reference,
                                           const Transform& O_T_EE_d, const JointSensors& sensors,
                                           const MeasuredArm& measured, const model::ArmModel& arm,
                                           const ArmSetup& setup) const noexcept {
  constexpr Vector3 kNoGravity{0, 0, 0};
  const model::Configuration& q = measured.q;
  const Transform O_T_K = model::Multiply(measured.EE.O_T_frame, setup.EE_T_K);
  const TaskInertia::TaskJacobian J = JacobianAt(O_T_K, measured.EE);
  const JointSquare M = internal::InertiaWithRotors(arm, q, setup.payload, rotor_inertia_);
  const TaskInertia inertia(M, J, kRegularisation);

  const Eigen::Map<const Task> K_x(K_x_.data());
  const JointColumn dq_error = Column(reference.dq_d) - Column(sensors.dq);
  const JointColumn q_error = Column(reference.q_d) - Column(sensors.q);
  const Task Lambda_ii = inertia.Diagonal();
  const Task D_x =
      2 * damping_ratio_ * K_x.cwiseProduct(Lambda_ii.cwiseMin(kHeaviestDamped)).cwiseSqrt();
  const Task e = Error(O_T_K, model::Multiply(O_T_EE_d, setup.EE_T_K));
  const JointColumn D_n = 2 * damping_ratio_ * (kNullStiffness * M.diagonal()).cwiseSqrt();
  const JointColumn tau_n = kNullStiffness * q_error + D_n.cwiseProduct(dq_error);
  const Task F =
      K_x.cwiseProduct(e) + D_x.cwiseProduct(J * dq_error) - TaskForce(inertia, Lambda_ii, tau_n);
  const JointColumn spring = J.transpose() * F + tau_n;

  const JointVector dynamics =
      arm.InverseDynamics(q, sensors.dq, reference.ddq_d, setup.payload, kNoGravity);
  ImpedanceTorque torque;
  for (std::size_t i = 0; i < kJoints; ++i) {
    torque.tau_J_d[i] = dynamics[i] + rotor_inertia_[i] * reference.ddq_d[i] + spring[i];
    torque.tau[i] = torque.tau_J_d[i] + measured.g[i];
  }
  return torque;
}

}  // namespace twin::onboard

#include "twin/onboard/guiding.h"

#include "onboard/task_inertia.h"
#include "twin/model/transform.h"

namespace twin::onboard {
namespace {

using internal::Column;
using internal::JointColumn;
using internal::JointSquare;
using GuidingInertia = internal::TaskInertia<7>;
using GuidingTask = GuidingInertia::Task;
using Jacobian = Eigen::Matrix<double, 6, kJoints>;

constexpr int kNullAxis = 6;

const GuidingTask kStiffness =
    (GuidingTask() << 40000, 40000, 40000, 2000, 2000, 2000, 1000).finished();
const GuidingTask kHeaviestGuided = (GuidingTask() << 50, 50, 50, 5, 5, 5, 5).finished();
const GuidingTask kGuidingRegularisation =
    (GuidingTask() << 1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-3, 1e-3).finished();
/// Of free axes, Ns/m and Nms/rad.
const GuidingTask kLightDamping = (GuidingTask() << 30, 30, 30, 3, 3, 3, 3).finished();
constexpr double kJointDamping = 0.3;  // Nms/rad

/// Unit vector of the joint motion that leaves EE in place, with the sign of `last`.
JointColumn NullVector(const Jacobian& J, const JointColumn& last) noexcept {
  const Eigen::HouseholderQR<Eigen::Matrix<double, kJoints, 6>> qr(J.transpose());
  JointColumn n = JointColumn::Unit(kJoints - 1);
  n.applyOnTheLeft(qr.householderQ());
  return n.dot(last) < 0 ? JointColumn(-n) : n;
}

}  // namespace

void Guiding::Begin(const JointVector& q, const ArmSetup& setup) noexcept {
  const Transform O_T_EE =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q, setup.F_T_EE);
  held_position_ = model::Position(O_T_EE);
  held_orientation_ = model::Orientation(O_T_EE);
  null_vector_.setZero();
  null_error_ = 0;
  last_q_ = q;
}

bool Guiding::IsLocked(int axis) const noexcept {
  return axis == kNullAxis ? !mode_.elbow : !mode_.axes[static_cast<std::size_t>(axis)];
}

Guiding::Axes Guiding::Follow(const Transform& O_T_EE) noexcept {
  const Eigen::Quaterniond R = model::Orientation(O_T_EE);
  Axes e;
  e.head<3>() = held_position_ - model::Position(O_T_EE);
  e.segment<3>(3) = model::Log(held_orientation_ * R.conjugate());
  e[kNullAxis] = null_error_;
  for (int axis = 0; axis <= kNullAxis; ++axis) {
    if (!IsLocked(axis)) e[axis] = 0;
  }
  held_position_ = model::Position(O_T_EE) + e.head<3>();
  held_orientation_ = (model::Exp(e.segment<3>(3)) * R).normalized();
  null_error_ = e[kNullAxis];
  return e;
}

ImpedanceTorque Guiding::Torque(const JointSensors& sensors, const MeasuredArm& measured,
                                const model::ArmModel& arm, const ArmSetup& setup) noexcept {
  const Jacobian J = Eigen::Map<const Jacobian>(measured.EE.J.data());
  null_vector_ = NullVector(J, null_vector_);
  null_error_ -= null_vector_.dot(Column(sensors.q) - Column(last_q_));
  last_q_ = sensors.q;
  const GuidingTask e = Follow(measured.EE.O_T_frame);

  GuidingInertia::TaskJacobian all;
  all << J, null_vector_.transpose();
  GuidingInertia::TaskJacobian locked = all;
  for (int axis = 0; axis <= kNullAxis; ++axis) {
    if (!IsLocked(axis)) locked.row(axis).setZero();
  }
  const JointSquare M = internal::InertiaWithRotors(arm, measured.q, setup.payload, rotor_inertia_);
  const GuidingTask inertia =
      GuidingInertia(M, locked, kGuidingRegularisation).Diagonal().cwiseMin(kHeaviestGuided);
  GuidingTask D = 2 * kStiffness.cwiseProduct(inertia).cwiseSqrt();
  for (int axis = 0; axis <= kNullAxis; ++axis) {
    if (!IsLocked(axis)) D[axis] = kLightDamping[axis];
  }
  const JointColumn dq = Column(sensors.dq);
  const GuidingTask F = kStiffness.cwiseProduct(e) - D.cwiseProduct(all * dq);
  const JointColumn held = all.transpose() * F - kJointDamping * dq;

  const JointVector c = arm.Coriolis(measured.q, sensors.dq, setup.payload);
  ImpedanceTorque torque;
  for (std::size_t i = 0; i < kJoints; ++i) {
    torque.tau_J_d[i] = held[i] + c[i];
    torque.tau[i] = torque.tau_J_d[i] + measured.g[i];
  }
  return torque;
}

}  // namespace twin::onboard

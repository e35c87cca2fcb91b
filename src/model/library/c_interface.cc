#include "twin/model/arm_model.h"

// The model library for clients: the 30 functions of FCI protocol 5, on the robot's own ArmModel.
// CMakeLists.txt describes how the file is made loadable anywhere.
//
// All pointers are to double; q and dq have 7 elements, transforms 16, Jacobians 42, the mass
// matrix 49, inertias 9, all column-major; vectors 3. The last parameter is the result. I, m and
// F_x_C are end effector and load as one body: the arm itself ends at the flange. Only joint 1
// moves frame 1, so its Jacobians take no q.
//
// Threads: any, concurrently. Real-time: nothing is allocated, locked or stored; inputs are copied
// before the result is written, so they may overlap it.

namespace {

using twin::JointVector;
using twin::Matrix3;
using twin::Transform;
using twin::Vector3;
using twin::model::ArmModel;
using twin::model::Frame;
using twin::model::Payload;

constexpr JointVector kAnywhere{};  // for frame 1's Jacobians, the same for every q

const ArmModel& Arm() noexcept {
  return ArmModel::TWIN_SERVED_ARM();
}

template <typename Array>
Array From(const double* in) noexcept {
  Array array;
  for (std::size_t i = 0; i < array.size(); ++i) array[i] = in[i];
  return array;
}

template <typename Array>
void To(double* out, const Array& array) noexcept {
  for (std::size_t i = 0; i < array.size(); ++i) out[i] = array[i];
}

Payload PayloadFrom(const double* I, double m, const double* F_x_C) noexcept {
  return {m, From<Vector3>(F_x_C), From<Matrix3>(I)};
}

void Pose(Frame frame, const double* q, double* out) noexcept {
  To(out, Arm().Pose(frame, From<JointVector>(q)));
}

void ZeroJacobian(Frame frame, const double* q, double* out) noexcept {
  To(out, Arm().ZeroJacobian(frame, From<JointVector>(q)));
}

void BodyJacobian(Frame frame, const double* q, double* out) noexcept {
  To(out, Arm().BodyJacobian(frame, From<JointVector>(q)));
}

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

// O_T_Jn: pose in the base of joint frame n; of the flange (8), of the end effector (9).

void O_T_J1(const double* q, double* out) noexcept {
  Pose(Frame::kJoint1, q, out);
}
void O_T_J2(const double* q, double* out) noexcept {
  Pose(Frame::kJoint2, q, out);
}
void O_T_J3(const double* q, double* out) noexcept {
  Pose(Frame::kJoint3, q, out);
}
void O_T_J4(const double* q, double* out) noexcept {
  Pose(Frame::kJoint4, q, out);
}
void O_T_J5(const double* q, double* out) noexcept {
  Pose(Frame::kJoint5, q, out);
}
void O_T_J6(const double* q, double* out) noexcept {
  Pose(Frame::kJoint6, q, out);
}
void O_T_J7(const double* q, double* out) noexcept {
  Pose(Frame::kJoint7, q, out);
}
void O_T_J8(const double* q, double* out) noexcept {
  Pose(Frame::kFlange, q, out);
}
void O_T_J9(const double* q, const double* F_T_EE, double* out) noexcept {
  To(out, Arm().Pose(Frame::kEndEffector, From<JointVector>(q), From<Transform>(F_T_EE)));
}

// O_J_Jn: zero Jacobian of the same frame, rows vx vy vz wx wy wz in base axes.

void O_J_J1(double* out) noexcept {
  ZeroJacobian(Frame::kJoint1, kAnywhere.data(), out);
}
void O_J_J2(const double* q, double* out) noexcept {
  ZeroJacobian(Frame::kJoint2, q, out);
}
void O_J_J3(const double* q, double* out) noexcept {
  ZeroJacobian(Frame::kJoint3, q, out);
}
void O_J_J4(const double* q, double* out) noexcept {
  ZeroJacobian(Frame::kJoint4, q, out);
}
void O_J_J5(const double* q, double* out) noexcept {
  ZeroJacobian(Frame::kJoint5, q, out);
}
void O_J_J6(const double* q, double* out) noexcept {
  ZeroJacobian(Frame::kJoint6, q, out);
}
void O_J_J7(const double* q, double* out) noexcept {
  ZeroJacobian(Frame::kJoint7, q, out);
}
void O_J_J8(const double* q, double* out) noexcept {
  ZeroJacobian(Frame::kFlange, q, out);
}
void O_J_J9(const double* q, const double* F_T_EE, double* out) noexcept {
  To(out, Arm().ZeroJacobian(Frame::kEndEffector, From<JointVector>(q), From<Transform>(F_T_EE)));
}

// Ji_J_Jn: body Jacobian of the same frame, rows in its own axes.

void Ji_J_J1(double* out) noexcept {
  BodyJacobian(Frame::kJoint1, kAnywhere.data(), out);
}
void Ji_J_J2(const double* q, double* out) noexcept {
  BodyJacobian(Frame::kJoint2, q, out);
}
void Ji_J_J3(const double* q, double* out) noexcept {
  BodyJacobian(Frame::kJoint3, q, out);
}
void Ji_J_J4(const double* q, double* out) noexcept {
  BodyJacobian(Frame::kJoint4, q, out);
}
void Ji_J_J5(const double* q, double* out) noexcept {
  BodyJacobian(Frame::kJoint5, q, out);
}
void Ji_J_J6(const double* q, double* out) noexcept {
  BodyJacobian(Frame::kJoint6, q, out);
}
void Ji_J_J7(const double* q, double* out) noexcept {
  BodyJacobian(Frame::kJoint7, q, out);
}
void Ji_J_J8(const double* q, double* out) noexcept {
  BodyJacobian(Frame::kFlange, q, out);
}
void Ji_J_J9(const double* q, const double* F_T_EE, double* out) noexcept {
  To(out, Arm().BodyJacobian(Frame::kEndEffector, From<JointVector>(q), From<Transform>(F_T_EE)));
}

// M ddq + c + g = tau.

void M_NE(const double* q, const double* I, double m, const double* F_x_C, double* out) noexcept {
  To(out, Arm().MassMatrix(From<JointVector>(q), PayloadFrom(I, m, F_x_C)));
}
void c_NE(const double* q, const double* dq, const double* I, double m, const double* F_x_C,
          double* out) noexcept {
  To(out, Arm().Coriolis(From<JointVector>(q), From<JointVector>(dq), PayloadFrom(I, m, F_x_C)));
}
void g_NE(const double* q, const double* g_earth, double m, const double* F_x_C,
          double* out) noexcept {
  // Gravity does not depend on inertia, hence no parameter.
  const Payload payload{m, From<Vector3>(F_x_C), {}};
  To(out, Arm().Gravity(From<JointVector>(q), payload, From<Vector3>(g_earth)));
}

}  // extern "C"
#pragma GCC visibility pop

#include <algorithm>
#include <cmath>

#include "model/joint_chain.h"
#include "twin/model/arm_model.h"

namespace twin::model {

using internal::BaseToTip;
using internal::Cross;
using internal::Dot;
using internal::kDh;
using internal::kFlangeOffset;
using internal::Offset;
using internal::operator+;
using internal::operator-;
using internal::operator*;

namespace {

/// A frame by its axes and its origin, in the base.
struct Axes {
  Vector3 x, y, z, p;
};

/// From joint frame i - 1 to joint frame i.
template <std::size_t i>
Axes Next(const Axes& parent, double s, double c) noexcept {
  constexpr Vector3 offset = Offset(i);
  Axes frame;
  frame.p = parent.p;
  if constexpr (offset[0] != 0) frame.p = frame.p + offset[0] * parent.x;
  if constexpr (offset[1] != 0) frame.p = frame.p + offset[1] * parent.y;
  if constexpr (offset[2] != 0) frame.p = frame.p + offset[2] * parent.z;
  Vector3 y;  // of the parent, tilted by alpha about its x axis
  if constexpr (kDh[i].sin_alpha == 0) {
    y = parent.y;
    frame.z = parent.z;
  } else if constexpr (kDh[i].sin_alpha == 1) {
    y = parent.z;
    frame.z = -parent.y;
  } else {
    y = -parent.z;
    frame.z = parent.y;
  }
  frame.x = c * parent.x + s * y;
  frame.y = c * y - s * parent.x;
  return frame;
}

/// All joint frames. The requested one is known only at run time, and stopping there would cost
/// more than computing the rest.
using JointFrames = std::array<Axes, kJoints>;

JointFrames FramesOf(const Configuration& q) noexcept {
  JointFrames frames;
  Axes axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {}};
  BaseToTip([&]<std::size_t i>() {
    axes = Next<i>(axes, q.sin[i], q.cos[i]);
    frames[i] = axes;
  });
  return frames;
}

/// Number of joints that move the frame.
std::size_t JointsBefore(Frame frame) noexcept {
  return std::min(static_cast<std::size_t>(frame) + 1, kJoints);
}

/// Selects the requested frame.
Axes Select(const JointFrames& joints, Frame frame, const Transform& F_T_EE) noexcept {
  if (frame < Frame::kFlange) return joints[static_cast<std::size_t>(frame)];
  Axes flange = joints[kJoints - 1];
  flange.p = flange.p + kFlangeOffset * flange.z;
  if (frame == Frame::kFlange) return flange;
  const auto rotated = [&](std::size_t column) {
    const double* v = &F_T_EE[4 * column];
    return v[0] * flange.x + v[1] * flange.y + v[2] * flange.z;
  };
  return {rotated(0), rotated(1), rotated(2), flange.p + rotated(3)};
}

void SetColumn(Jacobian& J, std::size_t joint, const Vector3& v, const Vector3& w) noexcept {
  for (std::size_t k = 0; k < 3; ++k) {
    J[6 * joint + k] = v[k];
    J[6 * joint + 3 + k] = w[k];
  }
}

Transform AsTransform(const Axes& frame) noexcept {
  const auto& [x, y, z, p] = frame;
  return {x[0], x[1], x[2], 0, y[0], y[1], y[2], 0, z[0], z[1], z[2], 0, p[0], p[1], p[2], 1};
}

/// @param count  number of joints that move the tip.
Jacobian ZeroJacobianOf(const JointFrames& joints, const Axes& tip, std::size_t count) noexcept {
  Jacobian J{};
  for (std::size_t i = 0; i < count; ++i) {
    SetColumn(J, i, Cross(joints[i].z, tip.p - joints[i].p), joints[i].z);
  }
  return J;
}

}  // namespace

Configuration::Configuration(const JointVector& q) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    sin[i] = std::sin(q[i]);
    cos[i] = std::cos(q[i]);
  }
}

Transform ArmModel::Pose(Frame frame, const Configuration& q,
                         const Transform& F_T_EE) const noexcept {
  return AsTransform(Select(FramesOf(q), frame, F_T_EE));
}

Jacobian ArmModel::ZeroJacobian(Frame frame, const Configuration& q,
                                const Transform& F_T_EE) const noexcept {
  const JointFrames joints = FramesOf(q);
  return ZeroJacobianOf(joints, Select(joints, frame, F_T_EE), JointsBefore(frame));
}

FrameMotion ArmModel::MotionOf(Frame frame, const Configuration& q,
                               const Transform& F_T_EE) const noexcept {
  const JointFrames joints = FramesOf(q);
  const Axes tip = Select(joints, frame, F_T_EE);
  return {AsTransform(tip), ZeroJacobianOf(joints, tip, JointsBefore(frame))};
}

Jacobian ArmModel::BodyJacobian(Frame frame, const Configuration& q,
                                const Transform& F_T_EE) const noexcept {
  const JointFrames joints = FramesOf(q);
  const Axes tip = Select(joints, frame, F_T_EE);
  const auto in_tip = [&](const Vector3& v) {
    return Vector3{Dot(tip.x, v), Dot(tip.y, v), Dot(tip.z, v)};
  };
  Jacobian J{};
  for (std::size_t i = 0; i < JointsBefore(frame); ++i) {
    const Vector3& z = joints[i].z;
    SetColumn(J, i, in_tip(Cross(z, tip.p - joints[i].p)), in_tip(z));
  }
  return J;
}

Vector6 ArmModel::Twist(Frame frame, const Configuration& q, const JointVector& dq,
                        const Transform& F_T_EE) const noexcept {
  return PoseAndTwist(frame, q, dq, F_T_EE).second;
}

std::pair<Transform, Vector6> ArmModel::PoseAndTwist(Frame frame, const Configuration& q,
                                                     const JointVector& dq,
                                                     const Transform& F_T_EE) const noexcept {
  const JointFrames joints = FramesOf(q);
  const Axes tip = Select(joints, frame, F_T_EE);
  Vector3 v{};
  Vector3 w{};
  for (std::size_t i = 0; i < JointsBefore(frame); ++i) {
    const Vector3 w_i = dq[i] * joints[i].z;
    v = v + Cross(w_i, tip.p - joints[i].p);
    w = w + w_i;
  }
  return {AsTransform(tip), {v[0], v[1], v[2], w[0], w[1], w[2]}};
}

Elbow ElbowOf(const JointVector& q) noexcept {
  const double sign = q[3] > kElbowFlipAngle ? 1 : q[3] < kElbowFlipAngle ? -1 : 0;
  return {q[2], sign};
}

}  // namespace twin::model

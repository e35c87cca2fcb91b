#include "twin/reference/rate_limiter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"

namespace twin::reference {
namespace {

constexpr double kMargin = 1e-3;
constexpr double kLostPackets = 3;
/// libfranka's value for any robot.
constexpr double kTranslationalVelocity = 2.0;  // m/s

/// A limit less the client's margin.
double Inside(double limit, double margin, const char* field, const std::string& owner) {
  const double left = limit - margin;
  if (left > 0 && std::isfinite(left)) return left;
  throw InputError(
      fmt::format("rate limiter: {} of {} is {}; it must be finite and above {}, which the limiter "
                  "stays inside of it",
                  field, owner, limit, margin));
}

double InsideVelocity(double limit, double client_acceleration, const char* field,
                      const std::string& owner) {
  return Inside(limit, kMargin + kLostPackets * kCycleSeconds * client_acceleration, field, owner);
}

CartesianBound Inside(const CartesianBound& bound, const std::string& owner) {
  CartesianBound inside;
  inside.dddp_max = Inside(bound.dddp_max, kMargin, "dddp_max", owner);
  inside.ddp_max = Inside(bound.ddp_max, kMargin, "ddp_max", owner);
  inside.dp_max = InsideVelocity(bound.dp_max, inside.ddp_max, "dp_max", owner);
  return inside;
}

}  // namespace

ClientLimits ClientLimits::Of(const JointLimits& joint, const CartesianLimits& cartesian) {
  ClientLimits limits;
  limits.joint = joint;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const std::string owner = fmt::format("joint {}", j + 1);
    limits.dtau_max[j] = Inside(joint.dtau_max[j], kMargin, "dtau_max", owner);
    limits.dddq_max[j] = Inside(joint.dddq_max[j], kMargin, "dddq_max", owner);
    limits.ddq_max[j] = Inside(joint.ddq_max[j], kMargin, "ddq_max", owner);
    limits.dq_max[j] = InsideVelocity(joint.dq_max[j], limits.ddq_max[j], "dq_max", owner);
  }
  CartesianBound translation = cartesian.translation;
  translation.dp_max = kTranslationalVelocity;
  limits.translation = Inside(translation, "the translation");
  limits.rotation = Inside(cartesian.rotation, "the rotation");
  limits.elbow = Inside(cartesian.elbow, "the elbow");
  return limits;
}

namespace {

using Eigen::Vector3d;

/// Share of the rotation's limits that a pose may use, since the robot derives the velocity from
/// matrices slightly differently.
constexpr double kPoseRotationShare = 0.99;

template <typename Values>
bool AllFinite(const Values& values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

/// Limits of one axis where it is.
struct AxisLimits {
  double v_min = 0;
  double v_max = 0;
  double a_max = 0;
  double j_max = 0;
};

/// One axis: see the header.
double LimitVelocity(double v_c, double v, double a, const AxisLimits& axis) noexcept {
  const double jerk = std::clamp(((v_c - v) / kT - a) / kT, -axis.j_max, axis.j_max);
  const double braking = axis.j_max / axis.a_max;
  const double highest = std::min(braking * (axis.v_max - v), axis.a_max);
  const double lowest = std::max(braking * (axis.v_min - v), -axis.a_max);
  return v + std::max(std::min(a + jerk * kT, highest), lowest) * kT;
}

double LimitPosition(double p_c, double p, double v, double a, const AxisLimits& axis) noexcept {
  if (!std::isfinite(p_c)) return p_c;
  return p + LimitVelocity((p_c - p) / kT, v, a, axis) * kT;
}

/// Of a joint at q.
AxisLimits AxisAt(const ClientLimits& limits, std::size_t joint, double q) noexcept {
  AxisLimits axis{.v_min = -limits.dq_max[joint],
                  .v_max = limits.dq_max[joint],
                  .a_max = limits.ddq_max[joint],
                  .j_max = limits.dddq_max[joint]};
  if (limits.joint.deceleration[joint] == 0) return axis;
  const double margin = limits.joint.dq_max[joint] - limits.dq_max[joint];
  axis.v_max = std::max(limits.joint.UpperVelocity(joint, q) - margin, 0.0);
  axis.v_min = std::min(limits.joint.LowerVelocity(joint, q) + margin, 0.0);
  return axis;
}

/// Distance along the unit vector u from v to the sphere of radius v_max, or, if the line misses
/// it, to its closest point.
double DistanceToSphere(const Vector3d& v, const Vector3d& u, double v_max) noexcept {
  const double along = u.dot(v);
  return -along + std::sqrt(std::max(along * along - v.squaredNorm() + v_max * v_max, 0.0));
}

/// Three axes: see the header.
Vector3d LimitVelocity(const Vector3d& v_c, const Vector3d& v, const Vector3d& a_last,
                       const CartesianBound& bound) noexcept {
  constexpr double kNone = std::numeric_limits<double>::epsilon();
  const Vector3d jerk = ((v_c - v) / kT - a_last) / kT;
  const double jerk_norm = jerk.norm();
  Vector3d a = a_last;
  if (jerk_norm > kNone) a += jerk * (std::min(jerk_norm, bound.dddp_max) / jerk_norm * kT);
  const double a_norm = a.norm();
  if (!(a_norm > kNone)) return v;
  const Vector3d u = a / a_norm;
  const double safe = bound.dddp_max / bound.ddp_max * DistanceToSphere(v, u, bound.dp_max);
  return v + u * (std::min(a_norm, std::clamp(safe, -bound.ddp_max, bound.ddp_max)) * kT);
}

CartesianBound Scaled(const CartesianBound& bound, double share) noexcept {
  return {share * bound.dp_max, share * bound.ddp_max, share * bound.dddp_max};
}

}  // namespace

JointVector LimitJointPosition(const JointVector& q_c, const JointVector& q_d,
                               const JointVector& dq_d, const JointVector& ddq_d,
                               const ClientLimits& limits) noexcept {
  JointVector q;
  for (std::size_t j = 0; j < kJoints; ++j) {
    q[j] = LimitPosition(q_c[j], q_d[j], dq_d[j], ddq_d[j], AxisAt(limits, j, q_d[j]));
  }
  return q;
}

JointVector LimitJointVelocity(const JointVector& dq_c, const JointVector& q_d,
                               const JointVector& dq_d, const JointVector& ddq_d,
                               const ClientLimits& limits) noexcept {
  JointVector dq = dq_c;
  for (std::size_t j = 0; j < kJoints; ++j) {
    if (!std::isfinite(dq_c[j])) continue;
    dq[j] = LimitVelocity(dq_c[j], dq_d[j], ddq_d[j], AxisAt(limits, j, q_d[j]));
  }
  return dq;
}

JointVector LimitTorque(const JointVector& tau_J_d_c, const JointVector& tau_J_d,
                        const ClientLimits& limits) noexcept {
  JointVector tau = tau_J_d_c;
  for (std::size_t j = 0; j < kJoints; ++j) {
    if (!std::isfinite(tau_J_d_c[j])) continue;
    const double rate = (tau_J_d_c[j] - tau_J_d[j]) / kT;
    tau[j] = tau_J_d[j] + std::clamp(rate, -limits.dtau_max[j], limits.dtau_max[j]) * kT;
  }
  return tau;
}

Transform LimitCartesianPose(const Transform& O_T_EE_c, const Transform& last,
                             const Vector6& O_dP_EE_c, const Vector6& O_ddP_EE_c,
                             const ClientLimits& limits) noexcept {
  if (!AllFinite(O_T_EE_c)) return O_T_EE_c;
  const Vector3d p = model::Position(last);
  const Vector3d v = LimitVelocity((model::Position(O_T_EE_c) - p) / kT, model::Linear(O_dP_EE_c),
                                   model::Linear(O_ddP_EE_c), limits.translation);
  const Vector3d w =
      LimitVelocity(model::TurnBetween(last, O_T_EE_c) / kT, model::Angular(O_dP_EE_c),
                    model::Angular(O_ddP_EE_c), Scaled(limits.rotation, kPoseRotationShare));
  return model::Turned(last, w * kT, p + v * kT);
}

Vector6 LimitCartesianVelocity(const Vector6& O_dP_EE_c, const Vector6& last,
                               const Vector6& O_ddP_EE_c, const ClientLimits& limits) noexcept {
  if (!AllFinite(O_dP_EE_c)) return O_dP_EE_c;
  const Vector3d v = LimitVelocity(model::Linear(O_dP_EE_c), model::Linear(last),
                                   model::Linear(O_ddP_EE_c), limits.translation);
  const Vector3d w = LimitVelocity(model::Angular(O_dP_EE_c), model::Angular(last),
                                   model::Angular(O_ddP_EE_c), limits.rotation);
  return {v[0], v[1], v[2], w[0], w[1], w[2]};
}

Elbow LimitElbow(const Elbow& elbow_c, const Elbow& last, const Elbow& delbow_c,
                 const Elbow& ddelbow_c, const ClientLimits& limits) noexcept {
  const CartesianBound& bound = limits.elbow;
  const AxisLimits axis{-bound.dp_max, bound.dp_max, bound.ddp_max, bound.dddp_max};
  return {LimitPosition(elbow_c[0], last[0], delbow_c[0], ddelbow_c[0], axis), elbow_c[1]};
}

}  // namespace twin::reference

#include "twin/reference/rejoining_generator.h"

#include <cstddef>

#include "reference/saturated_correction.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"

namespace twin::reference {
namespace {

using Eigen::Vector3d;

/// Velocity, base axes, from one pose to the next in a cycle.
struct Twist {
  Vector3d v;
  Vector3d w;
};
Twist TwistBetween(const Transform& from, const Transform& to) noexcept {
  return {(model::Position(to) - model::Position(from)) / kT, model::TurnBetween(from, to) / kT};
}

}  // namespace

RejoiningGenerator::RejoiningGenerator(const JointLimits& limits) noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) limits_[i] = BoundOf(limits, i);
}

JointVector RejoiningGenerator::Next(const Played<JointVector>& r, const JointVector& q_d,
                                     const JointVector& dq_d,
                                     const JointVector& ddq_d) const noexcept {
  using Scalar = Eigen::Matrix<double, 1, 1>;
  JointVector q_c{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double v = (r[1][i] - r[2][i]) / kT;
    const double a = (v - (r[2][i] - r[3][i]) / kT) / kT;
    const double e = q_d[i] - r[1][i];
    q_c[i] = r[0][i] + e +
             kT * CorrectingVelocity<1>(Scalar(e), Scalar(dq_d[i] - v), Scalar(ddq_d[i] - a),
                                        std::abs(v), std::abs(a), limits_[i])[0];
  }
  return q_c;
}

RejoiningPoseGenerator::RejoiningPoseGenerator(const CartesianLimits& limits) noexcept
    : limits_(limits) {
  for (CartesianBound* bound : {&limits_.translation, &limits_.rotation}) {
    *bound = {kPoseShare * bound->dp_max, kPoseShare * bound->ddp_max,
              kPoseShare * bound->dddp_max};
  }
}

Transform RejoiningPoseGenerator::Next(const Played<Transform>& r,
                                       const RobotState& state) const noexcept {
  const Twist next = TwistBetween(r[1], r[0]);
  const Twist now = TwistBetween(r[2], r[1]);
  const Twist last = TwistBetween(r[3], r[2]);
  const Vector3d dv = (now.v - last.v) / kT;
  const Vector3d dw = (now.w - last.w) / kT;
  const Transform& X = state.O_T_EE_c;
  const Vector3d v = next.v + CorrectingVelocity<3>(model::Position(X) - model::Position(r[1]),
                                                    model::Linear(state.O_dP_EE_c) - now.v,
                                                    model::Linear(state.O_ddP_EE_c) - dv,
                                                    now.v.norm(), dv.norm(), limits_.translation);
  const Vector3d w = next.w + CorrectingVelocity<3>(model::TurnBetween(r[1], X),
                                                    model::Angular(state.O_dP_EE_c) - now.w,
                                                    model::Angular(state.O_ddP_EE_c) - dw,
                                                    now.w.norm(), dw.norm(), limits_.rotation);
  return model::Turned(X, kT * w, model::Position(X) + kT * v);
}

}  // namespace twin::reference

#include "twin/reference/reference_generator.h"

#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/model/transform.h"

namespace twin::reference {
namespace {

/// @param generator  name for the message. @throws InputError unless lambda is in (0, 1].
double CheckedLambda(std::string_view generator, double lambda) {
  if (lambda > 0 && lambda <= 1) return lambda;
  throw InputError(fmt::format("{}: lambda is {}; it must lie in (0, 1] (the paper's is 1e-3)",
                               generator, lambda));
}

}  // namespace

JointReferenceGenerator::JointReferenceGenerator(double lambda)
    : lambda_(CheckedLambda("joint reference generator", lambda)) {}

JointVector JointReferenceGenerator::Next(const JointVector& q_d,
                                          const JointTarget& target) const noexcept {
  JointVector q_s;
  for (std::size_t j = 0; j < kJoints; ++j) {
    q_s[j] = q_d[j] + kCycleSeconds * target.dq[j] + lambda_ * (target.q[j] - q_d[j]);
  }
  return q_s;
}

CartesianReferenceGenerator::CartesianReferenceGenerator(double lambda)
    : lambda_(CheckedLambda("Cartesian reference generator", lambda)) {}

Transform CartesianReferenceGenerator::Next(const Transform& O_T_EE_c,
                                            const PoseTarget& target) const noexcept {
  using Eigen::Vector3d;
  const Vector6& twist = target.O_dP_EE;
  const Vector3d v(twist[0], twist[1], twist[2]);
  const Vector3d w(twist[3], twist[4], twist[5]);
  const Vector3d p_c = model::Position(O_T_EE_c);
  const Vector3d p_error = model::Position(target.O_T_EE) - p_c;
  const Vector3d turn_error = model::TurnBetween(O_T_EE_c, target.O_T_EE);
  return model::Turned(O_T_EE_c, kCycleSeconds * w + lambda_ * turn_error,
                       p_c + kCycleSeconds * v + lambda_ * p_error);
}

}  // namespace twin::reference

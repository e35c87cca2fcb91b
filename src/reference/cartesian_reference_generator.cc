#include "twin/reference/cartesian_reference_generator.h"

#include "reference/correction.h"
#include "twin/core/time.h"
#include "twin/model/rotation.h"

namespace twin::reference {

CartesianReferenceGenerator::CartesianReferenceGenerator(double lambda)
    : lambda_(internal::CheckedLambda("Cartesian reference generator", lambda)) {}

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

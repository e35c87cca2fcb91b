#include "twin/onboard/external_wrench.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "onboard/factors.h"

namespace twin::onboard {
namespace {

using Inverse = internal::Inverse<6>;
using Column6 = Inverse::Column;
using JacobianMap = Eigen::Map<const Eigen::Matrix<double, 6, kJoints>>;
using TransformMap = Eigen::Map<const Eigen::Matrix4d>;

/// The lower triangle of J J^T.
Inverse::Square Gram(const JacobianMap& J) noexcept {
  Inverse::Square JJt;
  TWIN_UNROLL
  for (int row = 0; row < 6; ++row) {
    TWIN_UNROLL
    for (int column = 0; column <= row; ++column) {
      double sum = 0;
      TWIN_UNROLL
      for (int k = 0; k < static_cast<int>(kJoints); ++k) sum += J(row, k) * J(column, k);
      JJt(row, column) = sum;
    }
  }
  return JJt;
}

/// 1 up to kFadesFrom of gain_max, 0 from gain_max on, linear in the gain's square between.
double ShareAt(double gain_squared, double gain_max) noexcept {
  constexpr double kFadesFrom = 0.8;
  const double from = kFadesFrom * kFadesFrom * gain_max * gain_max;
  return std::clamp((gain_max * gain_max - gain_squared) / (gain_max * gain_max - from), 0.0, 1.0);
}

}  // namespace

ExternalWrench EstimateWrench(const JointVector& tau_ext_hat, const model::Jacobian& J,
                              const Transform& O_T_EE, const Transform& EE_T_K,
                              double gain_max) noexcept {
  const JacobianMap J_EE(J.data());
  const Inverse inverse(Gram(J_EE));
  const double share = inverse.is_definite() ? ShareAt(inverse.Diagonal().sum(), gain_max) : 0;
  ExternalWrench wrench;
  if (share == 0) return wrench;

  const Eigen::Map<const Eigen::Matrix<double, kJoints, 1>> tau(tau_ext_hat.data());
  const Column6 at_EE = share * inverse.Times(J_EE.lazyProduct(tau));
  const Eigen::Vector3d f = at_EE.head<3>();
  const Eigen::Matrix3d O_R_EE = TransformMap(O_T_EE.data()).topLeftCorner<3, 3>();
  const Eigen::Matrix3d O_R_K = O_R_EE * TransformMap(EE_T_K.data()).topLeftCorner<3, 3>();
  const Eigen::Vector3d lever = O_R_EE * TransformMap(EE_T_K.data()).topRightCorner<3, 1>();
  const Eigen::Vector3d m = at_EE.tail<3>() - lever.cross(f);

  Eigen::Map<Column6>(wrench.O_F_ext_hat_K.data()) << f, m;
  Eigen::Map<Column6>(wrench.K_F_ext_hat_K.data()) << O_R_K.transpose() * f, O_R_K.transpose() * m;
  return wrench;
}

}  // namespace twin::onboard

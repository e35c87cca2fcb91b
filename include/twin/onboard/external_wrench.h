#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// Wrench of the robot on its environment at the stiffness frame K: [force; moment about K], N and
/// Nm.
struct ExternalWrench {
  Vector6 O_F_ext_hat_K{};  ///< base axes
  Vector6 K_F_ext_hat_K{};  ///< axes of K
};

/// The wrench at K that best explains the external joint torques, with J_K the zero Jacobian of K:
///   O_F_ext_hat_K = (J_K^T)^+ tau_ext_hat.
/// It is exact when every contact is beyond joint 7; another contact appears as the equivalent push
/// at K. The best fit does not depend on the point, so it is computed at EE as (J J^T)^-1 J
/// tau_ext_hat and moved to K.
///
/// An error of tau_ext_hat, equal on all joints, enters the wrench at EE amplified by
///   gain = sqrt(trace((J J^T)^-1)) = sqrt(sum 1/sigma_i^2),
/// with sigma_i the singular values of J, in m, N and Nm. The gain grows without bound near a
/// singularity. Above `gain_max` both wrenches are zero; from 0.8 gain_max on they fade, so that
/// the wrench does not jump where an arm leaves a singularity. Source: FCI protocol 5, robot state
/// ("zeros near singularity"); gain and fading are decisions.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param tau_ext_hat  positive when the robot pushes. @param J  zero Jacobian of EE.
[[nodiscard]] ExternalWrench EstimateWrench(const JointVector& tau_ext_hat,
                                            const model::Jacobian& J, const Transform& O_T_EE,
                                            const Transform& EE_T_K,
                                            double gain_max) noexcept TWIN_REALTIME;

}  // namespace twin::onboard

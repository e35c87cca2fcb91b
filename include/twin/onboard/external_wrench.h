#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/model/arm_model.h"

namespace twin::onboard {

/// What the robot does to its environment at the stiffness frame K: [force; moment about K], N and
/// Nm.
struct ExternalWrench {
  Vector6 O_F_ext_hat_K{};  ///< base axes
  Vector6 K_F_ext_hat_K{};  ///< axes of K
};

/// The wrench at K that explains the external joint torques best, J_K the zero Jacobian of K:
///   O_F_ext_hat_K = (J_K^T)^+ tau_ext_hat.
/// It is exact when all that acts on the arm acts beyond joint 7. A push further down shows as what
/// it would be at K. What explains them best does not depend on the point, so it is sought at EE,
/// (J J^T)^-1 J tau_ext_hat, and moved to K.
///
/// An error of tau_ext_hat, alike on all joints, arrives in the wrench at EE enlarged by
///   gain = sqrt(trace((J J^T)^-1)) = sqrt(sum 1/sigma_i^2),
/// sigma_i the singular values of J, units of m, N and Nm. Near a singularity that grows without
/// bound; above `gain_max` both wrenches are zero, and from 0.8 of it on they fade, so that an arm
/// that leaves a singularity does not meet a force that was not there a cycle before. Source: FCI
/// protocol 5, robot state ("zeros near singularity"); measure and fading are ours.
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// @param tau_ext_hat  positive when the robot pushes. @param J  zero Jacobian of EE.
[[nodiscard]] ExternalWrench EstimateWrench(const JointVector& tau_ext_hat,
                                            const model::Jacobian& J, const Transform& O_T_EE,
                                            const Transform& EE_T_K,
                                            double gain_max) noexcept TWIN_REALTIME;

}  // namespace twin::onboard

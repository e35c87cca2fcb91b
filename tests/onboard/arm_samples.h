#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "model/model_samples.h"
#include "support/panda_limits.h"
#include "twin/onboard/sensing.h"

// What tests of INT's sensing and its controllers start from.
namespace twin::onboard {

inline constexpr JointVector kRotorInertia{0.605721456, 0.605721456, 0.462474144, 0.462474144,
                                           0.205544064, 0.205544064, 0.205544064};

/// An arm with the Franka Hand, K at EE.
ArmSetup HandSetup();

SensingConfig PandaSensing();

/// At rest, held against gravity.
JointSensors RestingAt(const JointVector& q);

/// A stiffness frame that is neither at EE nor along it.
inline constexpr Transform kTiltedK{0.36, 0.48, -0.8, 0, -0.8, 0.6,   0,    0,
                                    0.48, 0.64, 0.6,  0, 0.03, -0.05, 0.12, 1};

using Jacobian6 = Eigen::Matrix<double, 6, kJoints>;

/// The zero Jacobian of K.
Jacobian6 JacobianOf(const JointVector& q, const Transform& EE_T_K = kIdentityTransform);

/// J^T F: what a wrench on the arm at K does to the joints.
JointVector TorqueOf(const Vector6& F, const JointVector& q,
                     const Transform& EE_T_K = kIdentityTransform);

/// sqrt(sum 1/sigma^2) of the Jacobian of EE.
double WrenchGain(const JointVector& q);

/// Poses away from singularities, from the joints' limits, and from the arm itself; always the same
/// for the same index.
JointVector RegularPose(std::uint64_t index);

}  // namespace twin::onboard

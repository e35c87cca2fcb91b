#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Dense>

#include "model/model_samples.h"
#include "support/panda_limits.h"
#include "twin/core/random.h"
#include "twin/model/self_collision.h"
#include "twin/model/transform.h"
#include "twin/onboard/sensing.h"

// What tests of INT's sensing and its controllers start from.
namespace twin::onboard {

inline constexpr JointVector kRotorInertia{0.605721456, 0.605721456, 0.462474144, 0.462474144,
                                           0.205544064, 0.205544064, 0.205544064};

/// An arm with the Franka Hand, K at EE.
inline ArmSetup HandSetup() {
  ArmSetup setup;
  setup.F_T_EE = model::kHandPose;
  setup.payload = model::kHand;
  return setup;
}

inline SensingConfig PandaSensing() {
  SensingConfig config;
  config.joints = test::PandaLimits();
  config.cartesian = test::PandaCartesianLimits();
  return config;
}

/// At rest, held against gravity.
inline JointSensors RestingAt(const JointVector& q) {
  return {q, {}, model::ArmModel::Panda().Gravity(q, model::kHand), q, {}};
}

/// A stiffness frame that is neither at EE nor along it.
inline constexpr Transform kTiltedK{0.36, 0.48, -0.8, 0, -0.8, 0.6,   0,    0,
                                    0.48, 0.64, 0.6,  0, 0.03, -0.05, 0.12, 1};

using Jacobian6 = Eigen::Matrix<double, 6, kJoints>;

/// The zero Jacobian of K.
inline Jacobian6 JacobianOf(const JointVector& q, const Transform& EE_T_K = kIdentityTransform) {
  const model::Jacobian J = model::ArmModel::Panda().ZeroJacobian(
      model::Frame::kEndEffector, q, model::Multiply(model::kHandPose, EE_T_K));
  return Eigen::Map<const Jacobian6>(J.data());
}

/// J^T F: what a wrench on the arm at K does to the joints.
inline JointVector TorqueOf(const Vector6& F, const JointVector& q,
                            const Transform& EE_T_K = kIdentityTransform) {
  JointVector tau;
  Eigen::Map<Eigen::Matrix<double, kJoints, 1>>(tau.data()) =
      JacobianOf(q, EE_T_K).transpose() * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(F.data());
  return tau;
}

/// sqrt(sum 1/sigma^2) of the Jacobian of EE.
inline double WrenchGain(const JointVector& q) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd{Eigen::MatrixXd(JacobianOf(q))};
  return svd.singularValues().cwiseInverse().norm();
}

/// Poses away from singularities, from the joints' limits, and from the arm itself; always the same
/// for the same index.
inline JointVector RegularPose(std::uint64_t index) {
  const Random random(31, RandomStream::kTest);
  const JointLimits limits = test::PandaLimits();
  for (std::uint64_t attempt = 0;; ++attempt) {
    JointVector q;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double u = random.Uniform(1000 * index + attempt, static_cast<std::uint32_t>(i));
      q[i] = limits.q_min[i] + (0.15 + 0.7 * u) * (limits.q_max[i] - limits.q_min[i]);
    }
    if (WrenchGain(q) < 12 && model::SelfDistance(q, true) > 0.1) return q;
  }
}

}  // namespace twin::onboard

#include "onboard/arm_samples.h"

#include "support/dense.h"
#include "twin/core/random.h"
#include "twin/model/self_collision.h"
#include "twin/model/transform.h"

namespace twin::onboard {

ArmSetup HandSetup() {
  ArmSetup setup;
  setup.F_T_EE = model::kHandPose;
  setup.payload = model::kHand;
  return setup;
}

SensingConfig PandaSensing() {
  SensingConfig config;
  config.joints = test::PandaLimits();
  config.cartesian = test::PandaCartesianLimits();
  return config;
}

JointSensors RestingAt(const JointVector& q) {
  return {q, {}, model::ArmModel::Panda().Gravity(q, model::kHand), q, {}};
}

Jacobian6 JacobianOf(const JointVector& q, const Transform& EE_T_K) {
  const model::Jacobian J = model::ArmModel::Panda().ZeroJacobian(
      model::Frame::kEndEffector, q, model::Multiply(model::kHandPose, EE_T_K));
  return Eigen::Map<const Jacobian6>(J.data());
}

JointVector TorqueOf(const Vector6& F, const JointVector& q, const Transform& EE_T_K) {
  JointVector tau;
  Eigen::Map<Eigen::Matrix<double, kJoints, 1>>(tau.data()) =
      JacobianOf(q, EE_T_K).transpose() * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(F.data());
  return tau;
}

double WrenchGain(const JointVector& q) {
  return test::SingularValues(JacobianOf(q)).cwiseInverse().norm();
}

JointVector RegularPose(std::uint64_t index) {
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

#include "twin/onboard/cartesian_monitor.h"

#include <cmath>
#include <optional>

#include "onboard/bounds.h"
#include "twin/core/joint_vector.h"
#include "twin/core/setting.h"
#include "twin/model/transform.h"

namespace twin::onboard {
namespace {

using internal::BrokenBound;
using internal::IsWithin;

constexpr std::int8_t kTranslation = 0;
constexpr std::int8_t kRotation = 1;
constexpr std::int8_t kElbow = 2;

/// One derivative of a Cartesian reference.
struct Magnitudes {
  const Vector6& pose;
  double elbow;
  double CartesianBound::*bound;
};

/// Adds a violation for the first axis that exceeds its bound.
void CheckMagnitudes(RobotError error, const Magnitudes& values, bool has_elbow,
                     const CartesianLimits& limits, std::uint64_t message_id,
                     Violations& found) noexcept {
  const double v = HalfNorm(values.pose, 0);
  const double w = HalfNorm(values.pose, 3);
  const double v_max = limits.translation.*values.bound;
  const double w_max = limits.rotation.*values.bound;
  const double elbow_max = limits.elbow.*values.bound;
  if (!IsWithin(v, v_max)) {
    found.Add({error, kTranslation, v, v_max, message_id});
  } else if (!IsWithin(w, w_max)) {
    found.Add({error, kRotation, w, w_max, message_id});
  } else if (has_elbow && !IsWithin(std::abs(values.elbow), elbow_max)) {
    found.Add({error, kElbow, values.elbow, std::copysign(elbow_max, values.elbow), message_id});
  }
}

void CheckElbowRange(double elbow, const JointLimits& joints, std::uint64_t message_id,
                     Violations& found) noexcept {
  const std::optional<double> bound = BrokenBound(elbow, joints.q_min[2], joints.q_max[2]);
  if (!bound) return;
  found.Add({RobotError::kCartesianMotionGeneratorElbowLimitViolation, kElbow, elbow, *bound,
             message_id});
}

/// The larger magnitude; NaN counts as the largest.
double Larger(double a, double b) noexcept {
  return std::abs(a) >= std::abs(b) || std::isnan(a) ? std::abs(a) : std::abs(b);
}

/// Largest deviation from a rigid transform.
double Deviation(const Transform& X) noexcept {
  const Eigen::Map<const Eigen::Matrix4d> matrix(X.data());
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const Eigen::Matrix3d oblique = R.transpose() * R - Eigen::Matrix3d::Identity();
  const Eigen::RowVector4d row = matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1);
  double deviation = R.determinant() - 1;
  for (const double x : oblique.reshaped()) deviation = Larger(deviation, x);
  for (const double x : row) deviation = Larger(deviation, x);
  // A position that is not finite has an infinite deviation.
  for (std::size_t i = 12; i < 15; ++i) {
    if (!std::isfinite(X[i])) deviation = X[i];
  }
  return deviation;
}

}  // namespace

Violations CheckFrame(const Transform& O_T_EE_c, std::uint64_t message_id) noexcept {
  constexpr double kTolerance = 1e-5;  // of IsRigid()
  Violations found;
  if (!IsRigid(O_T_EE_c)) {
    found.Add({RobotError::kCartesianPositionMotionGeneratorInvalidFrame, -1, Deviation(O_T_EE_c),
               kTolerance, message_id});
  }
  return found;
}

Violations CheckStartPose(const Transform& O_T_EE_c, const Transform& O_T_EE_last,
                          const StartTolerance& tolerance, std::uint64_t message_id) noexcept {
  constexpr RobotError kError = RobotError::kCartesianPositionMotionGeneratorStartPoseInvalid;
  const double translation = (model::Position(O_T_EE_c) - model::Position(O_T_EE_last)).norm();
  const double rotation = model::TurnBetween(O_T_EE_last, O_T_EE_c).norm();
  Violations found;
  if (!IsWithin(translation, tolerance.translation_m)) {
    found.Add({kError, kTranslation, translation, tolerance.translation_m, message_id});
  } else if (!IsWithin(rotation, tolerance.rotation_rad)) {
    found.Add({kError, kRotation, rotation, tolerance.rotation_rad, message_id});
  }
  return found;
}

Violations CheckStartElbow(double elbow_c, double elbow_last, const StartTolerance& tolerance,
                           std::uint64_t message_id) noexcept {
  const double distance = std::abs(elbow_c - elbow_last);
  Violations found;
  if (!IsWithin(distance, tolerance.elbow_rad)) {
    found.Add({RobotError::kCartesianMotionGeneratorStartElbowInvalid, kElbow, distance,
               tolerance.elbow_rad, message_id});
  }
  return found;
}

Violations CheckElbowSign(double sign_c, double sign, std::uint64_t message_id) noexcept {
  Violations found;
  const bool is_sign = sign_c == 1 || sign_c == -1;
  if (!is_sign || sign_c != sign) {
    found.Add(
        {RobotError::kCartesianMotionGeneratorElbowSignInconsistent, -1, sign_c, sign, message_id});
  }
  return found;
}

Violations CheckCartesianStep(const CartesianReference& next, bool has_elbow,
                              const CartesianLimits& limits, const JointLimits& joints,
                              std::uint64_t message_id) noexcept {
  Violations found;
  CheckMagnitudes(RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
                  {next.O_ddP_EE_c, next.ddelbow_c, &CartesianBound::ddp_max}, has_elbow, limits,
                  message_id, found);
  CheckMagnitudes(RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity,
                  {next.O_dddP_EE_c, next.dddelbow_c, &CartesianBound::dddp_max}, has_elbow, limits,
                  message_id, found);
  if (!found.empty()) return found;
  CheckMagnitudes(RobotError::kCartesianMotionGeneratorVelocityLimitsViolation,
                  {next.O_dP_EE_c, next.delbow_c, &CartesianBound::dp_max}, has_elbow, limits,
                  message_id, found);
  if (has_elbow) CheckElbowRange(next.elbow_c[0], joints, message_id, found);
  return found;
}

}  // namespace twin::onboard

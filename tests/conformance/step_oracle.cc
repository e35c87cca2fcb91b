#include "conformance/step_oracle.h"

#include "conformance/pose_math.h"
#include "conformance/reference_rules.h"
#include "twin/core/time.h"

namespace twin::test {
namespace {

/// Rounding of positions of a few radians or metres in their difference quotients.
constexpr double kVelocityNoise = 4e-12;
constexpr double kAccelerationNoise = 4e-9;
constexpr double kJerkNoise = 4e-6;

/// Share of the new value in a first-order low-pass of this cut-off; 1000 Hz is off.
double Gain(double cutoff_hz) {
  return cutoff_hz >= 1000 ? 1.0 : kT / (kT + 1 / (2 * M_PI * cutoff_hz));
}

double Filtered(double value, double last, double cutoff_hz) {
  const double gain = Gain(cutoff_hz);
  return gain == 1 ? value : gain * value + (1 - gain) * last;
}

template <std::size_t N>
std::array<double, N> Filtered(const std::array<double, N>& value,
                               const std::array<double, N>& last, double cutoff_hz) {
  std::array<double, N> filtered{};
  for (std::size_t i = 0; i < N; ++i) filtered[i] = Filtered(value[i], last[i], cutoff_hz);
  return filtered;
}

template <std::size_t N>
std::array<double, N> Quotient(const std::array<double, N>& next,
                               const std::array<double, N>& last) {
  std::array<double, N> quotient{};
  for (std::size_t i = 0; i < N; ++i) quotient[i] = (next[i] - last[i]) / kT;
  return quotient;
}

JointMotion PositionStep(const JointVector& q, const JointVector& q_d, const JointVector& dq_d,
                         const JointVector& ddq_d) {
  JointMotion step;
  step.q = q;
  step.dq = Quotient(q, q_d);
  step.ddq = Quotient(step.dq, dq_d);
  step.dddq = Quotient(step.ddq, ddq_d);
  return step;
}

Transform FilteredPose(const RobotState& before, const Transform& pose, double cutoff_hz) {
  const double gain = Gain(cutoff_hz);
  if (gain == 1) return pose;
  Vector3 phi = RotationBetween(before.O_T_EE_c, pose);
  for (double& x : phi) x *= gain;
  Transform filtered = Turned(before.O_T_EE_c, phi);
  for (std::size_t i = 12; i < 15; ++i) {
    filtered[i] = Filtered(pose[i], before.O_T_EE_c[i], cutoff_hz);
  }
  return filtered;
}

void AddElbow(CartesianMotion& step, const RobotState& before, double elbow) {
  step.has_elbow = true;
  step.elbow = elbow;
  step.delbow = (elbow - before.elbow_c[0]) / kT;
  step.ddelbow = (step.delbow - before.delbow_c[0]) / kT;
  step.dddelbow = (step.ddelbow - before.ddelbow_c[0]) / kT;
}

Quantity Norms(RobotError error, const Vector6& twist, double elbow, const Vector3& limits,
               double noise) {
  Quantity quantity;
  quantity.error = error;
  quantity.size = 3;
  quantity.value = {Norm(Linear(twist)), Norm(Angular(twist)), std::abs(elbow)};
  for (std::size_t i = 0; i < 3; ++i) {
    quantity.low[i] = -limits[i];
    quantity.high[i] = limits[i];
  }
  quantity.noise = noise;
  return quantity;
}

/// The velocities that a joint may have before the step: an FR3's shrink towards the ends.
Quantity VelocityRange(RobotError error, const JointMotion& step, const JointLimits& limits,
                       double noise) {
  Quantity range{error, kJoints, step.dq, {}, {}, noise};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double q = step.q[i] - kT * step.dq[i];
    range.low[i] = -FastestFrom(q, -1, limits, i);
    range.high[i] = FastestFrom(q, 1, limits, i);
  }
  return range;
}

Verdict JudgeMotion(const JointMotion& step, const JointLimits& limits,
                    const std::array<RobotError, 4>& errors, double q_noise) {
  Verdict discontinuity;
  discontinuity.Examine(Magnitudes(errors[2], step.ddq, limits.ddq_max,
                                   kAccelerationNoise + 4 * q_noise / (kT * kT)));
  discontinuity.Examine(
      Magnitudes(errors[3], step.dddq, limits.dddq_max, kJerkNoise + 8 * q_noise / (kT * kT * kT)));
  Verdict envelope;
  envelope.Examine(VelocityRange(errors[1], step, limits, kVelocityNoise + 2 * q_noise / kT));
  envelope.Examine({errors[0], kJoints, step.q, limits.q_min, limits.q_max, q_noise});
  discontinuity.Then(envelope);
  return discontinuity;
}

bool IsFrame(const Transform& X) {
  for (const double x : X) {
    if (!std::isfinite(x)) return false;
  }
  const double det = X[0] * (X[5] * X[10] - X[9] * X[6]) - X[4] * (X[1] * X[10] - X[9] * X[2]) +
                     X[8] * (X[1] * X[6] - X[5] * X[2]);
  return X[3] == 0 && X[7] == 0 && X[11] == 0 && X[15] == 1 && Obliqueness(X) <= 1e-5 && det > 0;
}

}  // namespace

JointMotion JointStep(const RobotState& before, const RobotCommand& command,
                      MotionGeneratorMode mode, const setting::Filters& filters) {
  if (mode == MotionGeneratorMode::kJointPosition) {
    return PositionStep(Filtered(command.q_c, before.q_d, filters.joint_position_hz), before.q_d,
                        before.dq_d, before.ddq_d);
  }
  JointMotion step;
  step.dq = Filtered(command.dq_c, before.dq_d, filters.joint_velocity_hz);
  for (std::size_t i = 0; i < kJoints; ++i) step.q[i] = before.q_d[i] + kT * step.dq[i];
  step.ddq = Quotient(step.dq, before.dq_d);
  step.dddq = Quotient(step.ddq, before.ddq_d);
  return step;
}

CartesianMotion CartesianStep(const RobotState& before, const RobotCommand& command,
                              MotionGeneratorMode mode, const setting::Filters& filters) {
  CartesianMotion step;
  step.oblique = Obliqueness(before.O_T_EE_c);
  if (mode == MotionGeneratorMode::kCartesianPosition) {
    step.oblique += Obliqueness(command.O_T_EE_c);
    step.pose = FilteredPose(before, command.O_T_EE_c, filters.cartesian_position_hz);
    step.twist = TwistBetween(before.O_T_EE_c, step.pose);
  } else {
    step.twist = Filtered(command.O_dP_EE_c, before.O_dP_EE_c, filters.cartesian_velocity_hz);
    step.pose = After(before.O_T_EE_c, step.twist);
  }
  step.acceleration = Quotient(step.twist, before.O_dP_EE_c);
  step.jerk = Quotient(step.acceleration, before.O_ddP_EE_c);
  if (command.valid_elbow) {
    const double cutoff_hz = mode == MotionGeneratorMode::kCartesianPosition
                                 ? filters.cartesian_position_hz
                                 : filters.cartesian_velocity_hz;
    AddElbow(step, before, Filtered(command.elbow_c[0], before.elbow_c[0], cutoff_hz));
  }
  return step;
}

JointMotion HeldJointStep(const RobotState& before) {
  JointMotion step;
  step.ddq = before.ddq_d;
  for (std::size_t i = 0; i < kJoints; ++i) {
    step.dq[i] = before.dq_d[i] + kT * before.ddq_d[i];
    step.q[i] = before.q_d[i] + kT * step.dq[i];
  }
  return step;
}

CartesianMotion HeldCartesianStep(const RobotState& before, bool has_elbow) {
  CartesianMotion step;
  step.oblique = Obliqueness(before.O_T_EE_c);
  step.acceleration = before.O_ddP_EE_c;
  for (std::size_t i = 0; i < 6; ++i) {
    step.twist[i] = before.O_dP_EE_c[i] + kT * before.O_ddP_EE_c[i];
  }
  step.pose = After(before.O_T_EE_c, step.twist);
  if (!has_elbow) return step;
  step.has_elbow = true;
  step.ddelbow = before.ddelbow_c[0];
  step.delbow = before.delbow_c[0] + kT * step.ddelbow;
  step.elbow = before.elbow_c[0] + kT * step.delbow;
  return step;
}

JointMotion JointStepTo(const RobotState& before, const JointVector& q) {
  return PositionStep(q, before.q_d, before.dq_d, before.ddq_d);
}

JointMotion Standing(const JointMotion& motion) {
  return PositionStep(motion.q, motion.q, motion.dq, motion.ddq);
}

CartesianMotion Standing(const CartesianMotion& motion) {
  CartesianMotion step;
  step.oblique = motion.oblique;
  step.pose = motion.pose;
  step.acceleration = Quotient(step.twist, motion.twist);
  step.jerk = Quotient(step.acceleration, motion.acceleration);
  if (!motion.has_elbow) return step;
  step.has_elbow = true;
  step.elbow = motion.elbow;
  step.ddelbow = -motion.delbow / kT;
  step.dddelbow = (step.ddelbow - motion.ddelbow) / kT;
  return step;
}

JointVector TorqueStep(const RobotState& before, const RobotCommand& command,
                       const setting::Filters& filters) {
  return Filtered(command.tau_J_d, before.tau_J_d, filters.controller_hz);
}

Verdict JudgeJoints(const JointMotion& step, const JointLimits& limits) {
  return JudgeMotion(step, limits,
                     {RobotError::kJointMotionGeneratorPositionLimitsViolation,
                      RobotError::kJointMotionGeneratorVelocityLimitsViolation,
                      RobotError::kJointMotionGeneratorVelocityDiscontinuity,
                      RobotError::kJointMotionGeneratorAccelerationDiscontinuity},
                     0);
}

Verdict JudgeCompletion(const JointMotion& step, const JointLimits& limits, double noise) {
  return JudgeMotion(step, limits,
                     {RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation,
                      RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation,
                      RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity,
                      RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity},
                     noise);
}

Verdict JudgeCartesian(const CartesianMotion& step, const OracleLimits& limits) {
  const CartesianBound& t = limits.cartesian.translation;
  const CartesianBound& r = limits.cartesian.rotation;
  const CartesianBound& e = limits.cartesian.elbow;
  Verdict discontinuity;
  discontinuity.Examine(Norms(RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
                              step.acceleration, step.ddelbow, {t.ddp_max, r.ddp_max, e.ddp_max},
                              kAccelerationNoise + 4 * step.oblique / (kT * kT)));
  discontinuity.Examine(Norms(RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity,
                              step.jerk, step.dddelbow, {t.dddp_max, r.dddp_max, e.dddp_max},
                              kJerkNoise + 8 * step.oblique / (kT * kT * kT)));
  Verdict envelope;
  envelope.Examine(Norms(RobotError::kCartesianMotionGeneratorVelocityLimitsViolation, step.twist,
                         step.delbow, {t.dp_max, r.dp_max, e.dp_max},
                         kVelocityNoise + 2 * step.oblique / kT));
  if (step.has_elbow) {
    constexpr RobotError kError = RobotError::kCartesianMotionGeneratorElbowLimitViolation;
    envelope.Examine(
        {kError, 1, {step.elbow}, {limits.joints.q_min[2]}, {limits.joints.q_max[2]}, 0});
  }
  discontinuity.Then(envelope);
  return discontinuity;
}

Verdict JudgeTorque(const JointVector& tau_d, const RobotState& before, const JointLimits& limits) {
  Verdict verdict;
  verdict.Examine(Magnitudes(RobotError::kControllerTorqueDiscontinuity,
                             Quotient(tau_d, before.tau_J_d), limits.dtau_max, 1e-9));
  return verdict;
}

Verdict JudgeShape(const RobotState& before, const RobotCommand& command, MotionGeneratorMode mode,
                   bool is_first, bool had_elbow, const setting::Filters& filters,
                   const OracleLimits& limits) {
  const bool is_pose = mode == MotionGeneratorMode::kCartesianPosition;
  const bool is_cartesian = is_pose || mode == MotionGeneratorMode::kCartesianVelocity;
  Verdict frame;
  if (is_pose && !IsFrame(command.O_T_EE_c)) {
    frame.Raise(RobotError::kCartesianPositionMotionGeneratorInvalidFrame);
    return frame;
  }
  Verdict start;
  if (is_first && mode == MotionGeneratorMode::kJointPosition) {
    const JointMotion step = JointStep(before, command, mode, filters);
    JointVector distance{};
    JointVector limit{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      distance[i] = std::abs(step.q[i] - before.q_d[i]);
      limit[i] = limits.start_q_rad;
    }
    start.Examine(Magnitudes(RobotError::kJointPositionMotionGeneratorStartPoseInvalid, distance,
                             limit, 1e-15));
  }
  if (is_first && is_pose) {
    Quantity distance;
    distance.error = RobotError::kCartesianPositionMotionGeneratorStartPoseInvalid;
    distance.size = 2;
    const CartesianMotion step = CartesianStep(before, command, mode, filters);
    distance.value = {Norm(Linear(step.twist)) * kT, Norm(Angular(step.twist)) * kT};
    distance.low = {-1, -1};
    distance.high = {limits.start_translation_m, limits.start_rotation_rad};
    distance.noise = 1e-12 + step.oblique;
    start.Examine(distance);
  }
  if (is_cartesian && command.valid_elbow && !had_elbow) {
    Quantity distance;
    distance.error = RobotError::kCartesianMotionGeneratorStartElbowInvalid;
    distance.size = 1;
    const CartesianMotion step = CartesianStep(before, command, mode, filters);
    distance.value = {std::abs(step.elbow - before.elbow_c[0])};
    distance.low = {-1};
    distance.high = {limits.start_elbow_rad};
    distance.noise = 1e-15;
    start.Examine(distance);
  }
  Verdict sign;
  if (is_cartesian && command.valid_elbow && command.elbow_c[1] != before.elbow_d[1]) {
    sign.Raise(RobotError::kCartesianMotionGeneratorElbowSignInconsistent);
  }
  start.Then(sign);
  return start;
}

}  // namespace twin::test

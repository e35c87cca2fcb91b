#include "conformance/reference_rules.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "conformance/pose_math.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::test {
namespace {

constexpr double kTolerance = 1e-9;

// Rounding of positions of a few radians or metres, and of their difference quotients.
constexpr double kPositionNoise = 1e-14;
constexpr double kVelocityNoise = 4e-12;
constexpr double kAccelerationNoise = 4e-9;
constexpr double kJerkNoise = 4e-6;

template <std::size_t N>
Finding FindDifference(const char* name, const std::array<double, N>& is,
                       const std::array<double, N>& should, double tolerance) {
  for (std::size_t i = 0; i < N; ++i) {
    if (std::abs(is[i] - should[i]) <= tolerance) continue;
    return fmt::format("{}[{}] is {:.17g}, should be {:.17g} (apart {:.3g}, allowed {:.3g})", name,
                       i, is[i], should[i], is[i] - should[i], tolerance);
  }
  return {};
}

template <std::size_t N>
Finding FindNotFinite(const char* name, const std::array<double, N>& values) {
  for (std::size_t i = 0; i < N; ++i) {
    if (!std::isfinite(values[i])) return fmt::format("{}[{}] is {}", name, i, values[i]);
  }
  return {};
}

Finding FindBeyond(const char* name, const JointVector& values, const JointVector& limits,
                   double noise) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(values[i]) <= limits[i] * (1 + kTolerance) + noise) continue;
    return fmt::format("{}[{}] is {:.17g}, its limit is {}", name, i, values[i], limits[i]);
  }
  return {};
}

/// The first of some findings.
Finding First(std::initializer_list<Finding> findings) {
  for (const Finding& finding : findings) {
    if (finding) return finding;
  }
  return {};
}

JointVector Jerk(const RobotState& before, const RobotState& after) {
  JointVector jerk{};
  for (std::size_t i = 0; i < kJoints; ++i) jerk[i] = (after.ddq_d[i] - before.ddq_d[i]) / kT;
  return jerk;
}

/// The largest velocity a joint reaches when its acceleration is taken off as fast as may be.
double UnavoidablePeak(double dq, double ddq, double dddq_max) {
  double speed = std::abs(dq);
  double acceleration = dq * ddq > 0 || dq == 0 ? std::abs(ddq) : 0;
  double peak = speed;
  while (acceleration > 0) {
    acceleration -= dddq_max * kT;
    speed += std::max(acceleration, 0.0) * kT;
    peak = std::max(peak, speed);
  }
  return peak;
}

}  // namespace

double FastestFrom(double q, double dq, const JointLimits& limits, std::size_t joint) {
  if (limits.deceleration[joint] == 0) return limits.dq_max[joint];
  const double left = dq < 0 ? q - limits.q_min[joint] : limits.q_max[joint] - q;
  const double braking = std::sqrt(2 * limits.deceleration[joint] * std::max(0.0, left));
  return std::min(limits.dq_max[joint], std::max(0.0, braking - limits.velocity_offset[joint]));
}

Finding FindNotFinite(const RobotState& s) {
  return First({FindNotFinite("O_T_EE", s.O_T_EE),
                FindNotFinite("O_T_EE_d", s.O_T_EE_d),
                FindNotFinite("O_T_EE_c", s.O_T_EE_c),
                FindNotFinite("O_dP_EE_d", s.O_dP_EE_d),
                FindNotFinite("O_dP_EE_c", s.O_dP_EE_c),
                FindNotFinite("O_ddP_EE_c", s.O_ddP_EE_c),
                FindNotFinite("elbow_c", s.elbow_c),
                FindNotFinite("delbow_c", s.delbow_c),
                FindNotFinite("ddelbow_c", s.ddelbow_c),
                FindNotFinite("q", s.q),
                FindNotFinite("dq", s.dq),
                FindNotFinite("q_d", s.q_d),
                FindNotFinite("dq_d", s.dq_d),
                FindNotFinite("ddq_d", s.ddq_d),
                FindNotFinite("tau_J", s.tau_J),
                FindNotFinite("tau_J_d", s.tau_J_d),
                FindNotFinite("dtau_J", s.dtau_J),
                FindNotFinite("theta", s.theta),
                FindNotFinite("dtheta", s.dtheta),
                FindNotFinite("tau_ext_hat_filtered", s.tau_ext_hat_filtered),
                FindNotFinite("O_F_ext_hat_K", s.O_F_ext_hat_K),
                FindNotFinite("K_F_ext_hat_K", s.K_F_ext_hat_K),
                FindNotFinite("elbow", s.elbow),
                FindNotFinite("elbow_d", s.elbow_d),
                FindNotFinite("joint_contact", s.joint_contact),
                FindNotFinite("cartesian_contact", s.cartesian_contact),
                FindNotFinite("joint_collision", s.joint_collision),
                FindNotFinite("cartesian_collision", s.cartesian_collision),
                FindNotFinite("accelerometer_top", s.accelerometer_top),
                FindNotFinite("accelerometer_bottom", s.accelerometer_bottom)});
}

Finding FindInconsistency(const RobotState& before, const RobotState& s) {
  const model::ArmModel& arm = model::ArmModel::Panda();
  const model::Configuration q_d(s.q_d);
  const model::Frame ee = model::Frame::kEndEffector;
  JointVector dtau{};
  for (std::size_t i = 0; i < kJoints; ++i) dtau[i] = (s.tau_J[i] - before.tau_J[i]) / kT;
  return First(
      {FindDifference("F_T_EE", s.F_T_EE, model::Multiply(s.F_T_NE, s.NE_T_EE), 1e-12),
       FindDifference("O_T_EE", s.O_T_EE, arm.Pose(ee, s.q, s.F_T_EE), 1e-12),
       FindDifference("O_T_EE_d", s.O_T_EE_d, arm.Pose(ee, q_d, s.F_T_EE), 1e-12),
       FindDifference("O_dP_EE_d", s.O_dP_EE_d, arm.Twist(ee, q_d, s.dq_d, s.F_T_EE), 1e-11),
       FindDifference("elbow", s.elbow, model::ElbowOf(s.q), 0),
       FindDifference("elbow_d", s.elbow_d, model::ElbowOf(s.q_d), 0),
       FindDifference("dtau_J", s.dtau_J, dtau, 1e-9)});
}

Finding FindOffStep(const JointMotion& step, const RobotState& after) {
  return First({FindDifference("q_d", after.q_d, step.q, kPositionNoise),
                FindDifference("dq_d", after.dq_d, step.dq, kVelocityNoise),
                FindDifference("ddq_d", after.ddq_d, step.ddq, kAccelerationNoise)});
}

Finding FindOffStep(const CartesianMotion& step, const RobotState& after) {
  const double noise = 2 * step.oblique;
  Finding pose =
      First({FindDifference("O_T_EE_c", after.O_T_EE_c, step.pose, kPositionNoise + noise),
             FindDifference("O_dP_EE_c", after.O_dP_EE_c, step.twist, kVelocityNoise + noise / kT),
             FindDifference("O_ddP_EE_c", after.O_ddP_EE_c, step.acceleration,
                            kAccelerationNoise + noise / (kT * kT))});
  if (pose || !step.has_elbow) return pose;
  return First(
      {FindDifference<1>("elbow_c", {after.elbow_c[0]}, {step.elbow}, kPositionNoise),
       FindDifference<1>("delbow_c", {after.delbow_c[0]}, {step.delbow}, kVelocityNoise),
       FindDifference<1>("ddelbow_c", {after.ddelbow_c[0]}, {step.ddelbow}, kAccelerationNoise)});
}

Finding FindBrokenDifferences(const RobotState& before, const RobotState& after) {
  JointVector q{};
  JointVector dq{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    q[i] = before.q_d[i] + kT * after.dq_d[i];
    dq[i] = before.dq_d[i] + kT * after.ddq_d[i];
  }
  return First({FindDifference("q_d", after.q_d, q, kPositionNoise),
                FindDifference("dq_d", after.dq_d, dq, kVelocityNoise)});
}

Finding FindBeyondLimits(const RobotState& before, const RobotState& after,
                         const JointLimits& limits) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double low = limits.q_min[i] - kTolerance * std::abs(limits.q_min[i]) - kPositionNoise;
    const double high = limits.q_max[i] + kTolerance * std::abs(limits.q_max[i]) + kPositionNoise;
    if (after.q_d[i] >= low && after.q_d[i] <= high) continue;
    return fmt::format("q_d[{}] is {:.17g}, allowed is [{}, {}]", i, after.q_d[i], limits.q_min[i],
                       limits.q_max[i]);
  }
  JointVector fastest{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    fastest[i] = FastestFrom(before.q_d[i], after.dq_d[i], limits, i);
  }
  return First({FindBeyond("dq_d", after.dq_d, fastest, kVelocityNoise),
                FindBeyond("ddq_d", after.ddq_d, limits.ddq_max, kAccelerationNoise),
                FindBeyond("dddq_d", Jerk(before, after), limits.dddq_max, kJerkNoise)});
}

bool IsAtRest(const RobotState& state) {
  return state.dq_d == JointVector{} && state.ddq_d == JointVector{};
}

Finding FindUnrest(const RobotState& before, const RobotState& after) {
  const Elbow none{};
  return First({FindDifference("q_d", after.q_d, before.q_d, 0),
                FindDifference("dq_d", after.dq_d, JointVector{}, 0),
                FindDifference("ddq_d", after.ddq_d, JointVector{}, 0),
                FindDifference("O_T_EE_c", after.O_T_EE_c, after.O_T_EE_d, 0),
                FindDifference("O_dP_EE_c", after.O_dP_EE_c, Vector6{}, 0),
                FindDifference("O_ddP_EE_c", after.O_ddP_EE_c, Vector6{}, 0),
                FindDifference("elbow_c", after.elbow_c, after.elbow_d, 0),
                FindDifference("delbow_c", after.delbow_c, none, 0),
                FindDifference("ddelbow_c", after.ddelbow_c, none, 0)});
}

Finding FindBadBraking(const RobotState& before, const RobotState& after, const JointLimits& limits,
                       bool took_over) {
  RobotState from = before;
  if (took_over) from.ddq_d = JointVector{};
  JointVector peak{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    peak[i] = std::max(limits.dq_max[i],
                       UnavoidablePeak(from.dq_d[i], from.ddq_d[i], limits.dddq_max[i]));
  }
  return First(
      {FindBrokenDifferences(from, after),
       FindBeyond("while braking, dq_d", after.dq_d, peak, kVelocityNoise),
       FindBeyond("while braking, ddq_d", after.ddq_d, limits.ddq_max, kAccelerationNoise),
       FindBeyond("while braking, dddq_d", Jerk(from, after), limits.dddq_max, kJerkNoise)});
}

int LongestBraking(const RobotState& state, const JointLimits& limits) {
  double seconds = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double A = limits.ddq_max[i];
    const double J = limits.dddq_max[i];
    // Taking off the acceleration, braking at A, and the ramps to A and from it.
    const double peak =
        std::abs(state.dq_d[i]) + state.ddq_d[i] * state.ddq_d[i] / (2 * J) + A * kT;
    seconds = std::max(seconds, std::abs(state.ddq_d[i]) / J + peak / A + 2 * A / J);
  }
  return static_cast<int>(std::ceil(seconds / kT)) + 4;
}

}  // namespace twin::test

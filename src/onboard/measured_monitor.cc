#include "twin/onboard/measured_monitor.h"

#include "onboard/bounds.h"
#include "twin/core/joint_vector.h"

namespace twin::onboard {
namespace {

using internal::BrokenBound;
using internal::CheckJointMagnitudes;
using internal::CheckJointRanges;
using internal::IsWithin;

}  // namespace

MeasuredMonitor::MeasuredMonitor(const JointLimits& joints, const CartesianLimits& cartesian,
                                 const MeasuredBounds& bounds) noexcept
    : v_max_(bounds.translation_max_m_per_s),
      w_max_(cartesian.rotation.dp_max * (1 + bounds.velocity_margin)),
      power_max_(bounds.power_max_W),
      clearance_(bounds.clearance_m) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    q_min_[i] = joints.q_min[i] - bounds.q_margin_rad;
    q_max_[i] = joints.q_max[i] + bounds.q_margin_rad;
    dq_max_[i] = joints.dq_max[i] * (1 + bounds.velocity_margin);
    tau_J_range_[i] = bounds.tau_J_range ? (*bounds.tau_J_range)[i] : 1.2 * joints.tau_max[i];
  }
}

Violations MeasuredMonitor::Check(const Measured& measured, const JointVector& tau_J_d,
                                  bool is_cartesian, std::uint64_t message_id) const noexcept {
  Violations found;
  CheckJoints(measured.sensors, message_id, found);
  CheckVelocity(measured, is_cartesian, message_id, found);
  CheckPower(measured, tau_J_d, message_id, found);
  if (measured.self_distance < clearance_) {
    found.Add({RobotError::kSelfCollisionAvoidanceViolation, -1, measured.self_distance, clearance_,
               message_id});
  }
  return found;
}

bool MeasuredMonitor::IsOutOfRange(const JointVector& q) const noexcept {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (BrokenBound(q[i], q_min_[i], q_max_[i])) return true;
  }
  return false;
}

void MeasuredMonitor::CheckJoints(const JointSensors& sensors, std::uint64_t message_id,
                                  Violations& found) const noexcept {
  CheckJointRanges(RobotError::kJointPositionLimitsViolation, sensors.q, q_min_, q_max_, message_id,
                   found);
  CheckJointMagnitudes(RobotError::kJointVelocityViolation, sensors.dq, dq_max_, message_id, found);
  CheckJointMagnitudes(RobotError::kTauJRangeViolation, sensors.tau_J, tau_J_range_, message_id,
                       found);
}

void MeasuredMonitor::CheckVelocity(const Measured& measured, bool is_cartesian,
                                    std::uint64_t message_id, Violations& found) const noexcept {
  const double v = HalfNorm(measured.O_dP_EE, 0);
  const double w = HalfNorm(measured.O_dP_EE, 3);
  if (!IsWithin(v, v_max_)) {
    found.Add({RobotError::kCartesianVelocityViolation, 0, v, v_max_, message_id});
  } else if (is_cartesian && !IsWithin(w, w_max_)) {
    found.Add({RobotError::kCartesianVelocityViolation, 1, w, w_max_, message_id});
  }
}

void MeasuredMonitor::CheckPower(const Measured& measured, const JointVector& tau_J_d,
                                 std::uint64_t message_id, Violations& found) const noexcept {
  const JointVector& g = measured.g;
  double power = 0;
  for (std::size_t i = 0; i < kJoints; ++i) power += (tau_J_d[i] + g[i]) * measured.sensors.dq[i];
  if (IsWithin(power, power_max_)) return;
  found.Add({RobotError::kPowerLimitViolation, -1, power, power_max_, message_id});
}

}  // namespace twin::onboard

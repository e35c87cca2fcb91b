#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::controllers {

/// Makes a torque controller start with the torque that held the arm:
///   tau = law(t) + f(t) b,   b = tau_J_d(0) - law(0),   f falls linearly from 1 to 0,
/// t since the first update, tau_J_d as the robot reports it then. Without it the law's initial
/// torque is a step: 1 mrad at 600 Nm/rad is 600 Nm/s of the robot's limit of 1000 Nm/s.
///
/// Threads: one. Real-time: noexcept, does not allocate.
class SoftStart {
 public:
  /// @param length  time over which f falls, >= 0; zero: f = 0.
  explicit SoftStart(Duration length) noexcept : length_(length) {}

  /// Sets b at the first update. @param law  torque of the law, Nm.
  void Begin(const RobotState& state, const JointVector& law) noexcept TWIN_REALTIME {
    for (std::size_t j = 0; j < kJoints; ++j) bump_[j] = state.tau_J_d[j] - law[j];
  }

  /// @param elapsed  since the first update. @param tau  the law's torque; f b is added.
  void AddTo(JointVector& tau, Duration elapsed) const noexcept TWIN_REALTIME {
    if (elapsed >= length_) return;
    const double f = 1 - ToSeconds(elapsed) / ToSeconds(length_);
    for (std::size_t j = 0; j < kJoints; ++j) tau[j] += f * bump_[j];
  }

 private:
  Duration length_;
  JointVector bump_{};  ///< b, Nm
};

}  // namespace twin::controllers

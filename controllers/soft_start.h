#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"

namespace twin::controllers {

/// Lets a torque controller begin with the very torque that held the arm:
///   tau = law(t) + f(t) b,   b = tau_J_d(0) - law(0),   f falls from 1 to 0 in a straight line,
/// t the time since the first update, tau_J_d what the robot reports then. Without it, what the law
/// asks for at once is a step: 1 mrad at 600 Nm/rad is 600 Nm/s of the 1000 Nm/s that the robot
/// takes.
///
/// Threads: one. Real-time: noexcept, allocates nothing.
class SoftStart {
 public:
  /// @param length  of the fading, >= 0; zero: none.
  explicit SoftStart(Duration length) noexcept : length_(length) {}

  /// The first update: takes b. @param law  the torque that the law asks for, Nm.
  void Begin(const RobotState& state, const JointVector& law) noexcept TWIN_REALTIME {
    for (std::size_t j = 0; j < kJoints; ++j) bump_[j] = state.tau_J_d[j] - law[j];
  }

  /// @param elapsed  since the first update. @param tau  the law's torque, to which f b is added.
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

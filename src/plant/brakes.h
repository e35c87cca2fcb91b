#pragma once

#include <array>

#include <mujoco/mujoco.h>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// The holding brakes of the joints, on the motors: closed, each takes whatever torque keeps its
/// joint where it is, up to twice the largest torque of its drive.
///
///   tau_brake = carried + row,   |carried|, |row| <= tau_max,   carried' = carried + row
///
/// `row` is the engine's dry friction, which yields a little to a steady load (5e-5 rad/s under
/// 20 Nm); what it took in one step is therefore carried over to the next, and a braked arm does
/// not creep. What the robot's brakes hold is not public; they must hold the arm with its largest
/// load in any pose, so tau_max at least. Twice that is our decision.
///
/// Threads: one thread. Real-time: all but the constructor are noexcept and allocate nothing.
class Brakes {
 public:
  /// @param dofs     the joints' in the model.
  /// @param tau_max  Nm, each > 0.
  Brakes(const mjModel& model, const std::array<int, kJoints>& dofs,
         const JointVector& tau_max) noexcept;

  /// Opens them without a step.
  void Reset(mjModel& model) noexcept;

  /// Opens or closes them for the steps to come, at once. May throw EngineFault.
  void Set(bool closed, mjModel& model, mjData& data) TWIN_REALTIME;

  /// Part of tau_brake to apply in the step to come, Nm; zero when open.
  [[nodiscard]] const JointVector& carried() const noexcept TWIN_REALTIME { return carried_; }

  /// To be called when the forces of a step are solved and its constraints are still there.
  /// @returns tau_brake of that step; zero when open.
  [[nodiscard]] JointVector Take(const mjData& data) noexcept TWIN_REALTIME;

 private:
  std::array<int, kJoints> dofs_;
  JointVector tau_max_;     ///< Nm
  JointVector friction_{};  ///< the joints' own frictionloss, Nm
  JointVector carried_{};
  bool closed_ = false;
};

}  // namespace twin::plant

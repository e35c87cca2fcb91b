#pragma once

#include <array>

#include <mujoco/mujoco.h>

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// The joints' holding brakes, on the motors: a closed brake applies the torque that holds its
/// joint, up to twice the largest torque of its drive.
///
///   tau_brake = carried + row,   |carried|, |row| <= tau_max,   carried' = carried + row
///
/// `row` is the engine's dry friction, which yields slightly to a steady load (5e-5 rad/s under 20
/// Nm). So its torque of one step is carried over to the next, and a braked arm does not creep. The
/// capacity of the robot's brakes is not public; they must hold the arm with its largest load in
/// any pose, hence at least tau_max. Twice that is a decision.
///
/// Threads: one thread. Real-time: all but the constructor are noexcept and allocate nothing.
class Brakes {
 public:
  /// @param dofs     the joints' in the model.
  /// @param tau_max  Nm, each > 0.
  Brakes(const mjModel& model, const std::array<int, kJoints>& dofs,
         const JointVector& tau_max) noexcept;

  /// Opens the brakes without a step.
  void Reset(mjModel& model) noexcept;

  /// Opens or closes them at once, for later steps. May throw EngineFault.
  void Set(bool closed, mjModel& model, mjData& data) TWIN_REALTIME;

  /// Part of tau_brake to apply in the next step, Nm; zero when open.
  [[nodiscard]] const JointVector& carried() const noexcept TWIN_REALTIME { return carried_; }

  /// After the forces of a step are solved, while its constraints are valid.
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

#pragma once

#include <array>

#include <mujoco/mujoco.h>

#include "plant/robot_description.h"
#include "twin/core/realtime.h"
#include "twin/plant/plant.h"

namespace twin::plant {

/// Inertia of the hand's drive reflected to a finger, kg. Not public; a decision: typical of a
/// small geared motor, and enough for a grasp to settle without chatter at 1 ms.
inline constexpr double kFingerInertia = 1;

/// The two fingers of a compiled model: one drive moves both, coupled by a stiff belt.
///
///   f_i = f_drive - D dx_i -+ (K (x_1 - x_2) + C (dx_1 - dx_2)),   x_i distance from the middle
///
/// D is the drive's friction, K and C are the belt's. Forces couple the fingers instead of an
/// engine constraint, so an arm without contact has no constraint to solve.
///
/// Threads: one thread. Real-time: all but the constructor are noexcept and allocate nothing.
class HandJoints final : public HandBody {
 public:
  /// @param robot  with two prismatic joints, like the model.
  HandJoints(const mjModel& model, const RobotDescription& robot) noexcept;

  /// Opens the hand. @param data  just reset; positions are not propagated.
  void Reset(mjData& data) noexcept;
  /// Before a step: applies the forces on the fingers.
  void Apply(mjData& data) const noexcept TWIN_REALTIME;
  /// After a step: reads the sensors.
  void Sense(const mjData& data) noexcept TWIN_REALTIME;

  void Drive(const HandDrive& drive) noexcept TWIN_REALTIME override { drive_ = drive; }
  [[nodiscard]] const HandSensors& sensors() const noexcept override { return sensors_; }

 private:
  struct Finger {
    int qpos = 0;
    int dof = 0;
  };
  std::array<Finger, 2> fingers_{};
  double open_ = 0;  ///< position of a finger at its upper limit, m
  HandDrive drive_;
  HandSensors sensors_;
};

}  // namespace twin::plant

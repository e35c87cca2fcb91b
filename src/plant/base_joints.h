#pragma once

#include <array>

#include <mujoco/mujoco.h>

#include "plant/robot_description.h"
#include "plant/tyre.h"
#include "twin/core/realtime.h"
#include "twin/plant/base_body.h"

namespace twin::plant {

/// Names of the wheels' links, in the order of the drives.
inline constexpr std::array<const char*, 4> kWheels{"front_left_wheel", "front_right_wheel",
                                                    "rear_left_wheel", "rear_right_wheel"};
/// Name of the link that the arm stands on.
inline constexpr const char* kArmMount = "arm_mount";

/// Inertia of a wheel's motor behind its gear, felt at the wheel, kg m^2. Not public; our decision:
/// a rotor of 5e-5 kg m^2 behind a gear of about 79.
inline constexpr double kWheelRotorInertia = 0.3;

/// The mobile base of a compiled model: its drives, its tyres, and how it comes to rest.
///
/// The engine finds where the wheels touch and what bears them, without friction; what keeps them
/// from slipping is a Tyre each, by the normal force of the step before. Only ground that is fixed
/// to the world gives them hold.
///
/// Threads: one thread. Real-time: Apply(), Take() and Sense() are noexcept and allocate nothing.
class BaseJoints final : public BaseBody {
 public:
  /// @param robot  whose root is the base's.
  BaseJoints(const mjModel& model, const RobotDescription& robot);

  /// Puts the base at rest on its tyres: lets it settle for half a second while nothing else
  /// moves, and takes height and attitude over. Everything is at rest after it.
  /// May throw EngineFault.
  void Settle(const mjModel& model, mjData& data);

  /// @throws InputError when the base, settled at `start`, does not stand there: names what it
  /// touches.
  void RequireStanding(const BasePose& start, const mjModel& model, const mjData& data) const;

  /// Before a step: torques on the wheels, friction on the tyres. @pre positions and velocities of
  /// `data` are propagated.
  void Apply(const mjModel& model, mjData& data) noexcept TWIN_REALTIME;
  /// To be called when the forces of a step are solved and its contacts are still there.
  void Take(const mjModel& model, const mjData& data) noexcept TWIN_REALTIME;
  /// After a step: reads the sensors.
  void Sense(const mjData& data) noexcept TWIN_REALTIME;

  void Drive(const WheelDrive& drive) noexcept TWIN_REALTIME override { drive_ = drive; }
  [[nodiscard]] const WheelSensors& sensors() const noexcept override { return sensors_; }

 private:
  struct Wheel {
    int body = 0;
    int qpos = 0;
    int dof = 0;
    double radius = 0;
    WheelLoad load;
    Tyre tyre;
  };
  /// Which of the wheels a body is; null: none.
  [[nodiscard]] Wheel* Find(int body) noexcept;

  int body_ = 0;
  int qpos_ = 0;  ///< of the base's free joint
  int dof_ = 0;
  std::array<Wheel, 4> wheels_{};
  WheelDrive drive_;
  WheelSensors sensors_;
};

/// Puts the base of a model where a run begins: as it stands on tyres that bear nothing yet.
void PlaceBase(const BasePose& start, const RobotDescription& robot, mjModel& model);

}  // namespace twin::plant

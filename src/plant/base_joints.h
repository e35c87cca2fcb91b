#pragma once

#include <array>

#include <mujoco/mujoco.h>

#include "plant/robot_description.h"
#include "plant/tyre.h"
#include "twin/core/realtime.h"
#include "twin/plant/plant.h"

namespace twin::plant {

/// Names of the wheels' links, in the order of the drives.
inline constexpr std::array<const char*, 4> kWheels{"front_left_wheel", "front_right_wheel",
                                                    "rear_left_wheel", "rear_right_wheel"};
/// Name of the link that carries the arm.
inline constexpr const char* kArmMount = "arm_mount";

/// Inertia of a wheel's motor behind its gear, reflected to the wheel, kg m^2. Not public; a
/// decision: a rotor of 5e-5 kg m^2 behind a gear of about 79.
inline constexpr double kWheelRotorInertia = 0.3;

/// The mobile base of a compiled model: drives, tyres and settling.
///
/// The engine computes the wheels' contacts and normal forces without friction. A Tyre per wheel
/// adds friction from the normal force of the last step. Only ground that is fixed to the world
/// gives grip.
///
/// Threads: one thread. Real-time: Apply(), Take() and Sense() are noexcept and allocate nothing.
class BaseJoints final : public BaseBody {
 public:
  /// @param robot  its root is the base's.
  BaseJoints(const mjModel& model, const RobotDescription& robot);

  /// Puts the base at rest on its tyres: lets it settle for half a second with everything else
  /// fixed, and keeps height and attitude. All velocities are zero afterwards. May throw
  /// EngineFault.
  void Settle(const mjModel& model, mjData& data);

  /// @throws InputError if the base, settled at `start`, does not stand there: names what it
  /// touches.
  void RequireStanding(const BasePose& start, const mjModel& model, const mjData& data) const;

  /// Before a step: applies wheel torques and tyre friction. @pre positions and velocities of
  /// `data` are propagated.
  void Apply(const mjModel& model, mjData& data) noexcept TWIN_REALTIME;
  /// After the forces of a step are solved, while its contacts are valid.
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
  /// The wheel of a body, or null.
  [[nodiscard]] Wheel* Find(int body) noexcept;

  int body_ = 0;
  int qpos_ = 0;  ///< of the base's free joint
  int dof_ = 0;
  std::array<Wheel, 4> wheels_{};
  WheelDrive drive_;
  WheelSensors sensors_;
};

/// Places the base of a model at the start of a run, on tyres without load.
void PlaceBase(const BasePose& start, const RobotDescription& robot, mjModel& model);

}  // namespace twin::plant

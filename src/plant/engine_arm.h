#pragma once

#include <array>
#include <optional>

#include <mujoco/mujoco.h>

#include "plant/base_joints.h"
#include "plant/brakes.h"
#include "plant/hand_joints.h"
#include "plant/perturber.h"
#include "plant/robot_description.h"
#include "plant/suction.h"
#include "plant/torque_delay.h"
#include "twin/core/body_interface.h"
#include "twin/core/random.h"
#include "twin/core/realtime.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// One arm of an engine's model, with hand, mobile base, brakes and sensors: what it adds to a step
/// that all arms of the model take together.
///
///     ClearForces -> Apply -> Drive -> (the engine solves) -> Take -> (the engine moves) -> Sense
///
/// Threads: one thread. Real-time: these six are noexcept, but for EngineFault of Drive() and
/// Take(), and allocate nothing.
class EngineArm {
 public:
  /// @param robot  its links and joints in `model`, which must outlive this.
  EngineArm(const MujocoPlantOptions& options, const RobotDescription& robot, const mjModel& model);

  /// All that changes beside the engine's data and the friction of closed brakes.
  struct Live {
    Perturber perturber;
    Brakes brakes;
    std::optional<HandJoints> hand{};
    std::optional<Suction> suction{};
    std::optional<BaseJoints> base{};
    JointVector tau_J{};  ///< of the last step, without noise
    TorqueDelay tau_J_late;
    JointSensors sensors{};
    JointDrive drive{};
  };
  /// Hand, suction and base stay where they are in memory when it is assigned: others refer to
  /// them.
  [[nodiscard]] Live& live() noexcept { return live_; }
  [[nodiscard]] const Live& live() const noexcept { return live_; }

  /// At rest at `q`, open hand, forces and brakes as at the beginning.
  void Reset(const JointVector& q, mjModel& model, mjData& data);
  /// Sensors after a reset. @pre the engine has computed from the positions.
  void SenseAtRest(const mjData& data) noexcept;

  void ClearForces(mjData& data) noexcept TWIN_REALTIME {
    if (live_.suction) live_.suction->Release(data);
    live_.perturber.ClearForces(data);
  }
  /// @param begin  plant time.
  void Apply(Duration begin, const mjModel& model, mjData& data) noexcept TWIN_REALTIME;
  /// By live().drive.
  void Drive(mjModel& model, mjData& data) TWIN_REALTIME;
  void Take(const mjModel& model, const mjData& data) TWIN_REALTIME;
  /// @param tick  of plant time: key of the noise.
  void Sense(const mjData& data, std::uint64_t tick) noexcept TWIN_REALTIME;
  /// The sensors of an arm whose motion is invalid.
  void Lose() noexcept TWIN_REALTIME;

  void Reseed(std::uint64_t seed) noexcept { random_ = Random(seed, RandomStream::kSensorNoise); }
  /// The gravity torque of `data`, whose velocity is zero. @pre mj_comVel.
  void SetJoints(const JointVector& q, mjData& data) const noexcept;
  [[nodiscard]] JointVector BiasIn(const mjData& data) const noexcept;
  /// Whether a joint of the model is this arm's or its hand's.
  [[nodiscard]] bool Has(int joint) const noexcept;

 private:
  /// Indices of the arm's joints in the engine's vectors, and their torque limits.
  struct Joints {
    std::array<int, kJoints> qpos{};
    std::array<int, kJoints> dof{};
    JointVector tau_max{};  ///< Nm
    std::vector<int> all;   ///< joints of the model, of hand and base too
  };
  [[nodiscard]] static Joints FindJoints(const mjModel& model, const RobotDescription& robot);
  [[nodiscard]] JointVector FrictionAt(const JointVector& dq) const noexcept TWIN_REALTIME;
  /// Reads the joints and adds this tick's noise.
  void SenseJoints(const JointVector& tau_J, const mjData& data,
                   std::uint64_t tick) noexcept TWIN_REALTIME;

  const FrictionProfile friction_;
  const std::optional<FrictionLaw> friction_law_;
  const SensorNoise noise_;
  Random random_;
  const Joints joints_;
  JointVector armature_{};
  const ElasticityProfile elasticity_;
  const JointVector stiffness_;
  JointVector friction_now_{};  ///< of the step, Nm
  JointVector tau_J_now_{};     ///< of the step, Nm
  Live live_;
};

}  // namespace twin::plant

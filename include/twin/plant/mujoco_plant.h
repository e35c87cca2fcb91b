#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "twin/plant/plant.h"
#include "twin/plant/truth_probe.h"

namespace twin::plant {

/// Friction of the joints. Figures and sources: twin/model/joint_friction.h
/// and src/plant/friction.h.
enum class FrictionProfile : std::uint8_t {
  kNone,      ///< frictionless
  kResidual,  ///< link-side rest friction after the robot's own compensation (sigmoid of Gaz et al.
              ///< 2019)
  kBreakaway,  ///< break-away torques as measured through the FCI on one Panda (franka_emulator),
               ///< plus viscous friction
};

/// What is mounted on the flange.
enum class HandKind : std::uint8_t {
  kNone,
  kFrankaHand,  ///< rigid here: mass, centre of mass and shape of the Franka hand with its fingers
};

/// Standard deviations of white noise added to the sensors; zero is off.
struct SensorNoise {
  double q_rad = 0;
  double dq_rad_per_s = 0;
  double tau_J_Nm = 0;
};

/// Everything a MuJoCo plant is made of.
struct MujocoPlantOptions {
  std::filesystem::path urdf;   ///< the arm
  std::filesystem::path scene;  ///< MJCF of the world around it; empty: a plain floor and a light
  std::filesystem::path
      mesh_package;  ///< folder of `panda_description`; empty or missing: primitive shapes
  std::filesystem::path cache;  ///< folder of compiled models; empty: no cache
  bool rebuild_cache = false;   ///< ignore and replace what the cache holds
  HandKind hand = HandKind::kFrankaHand;
  FrictionProfile friction = FrictionProfile::kResidual;
  bool armature = true;  ///< reflected rotor inertia of the drives
  SensorNoise noise;
  std::uint64_t seed = 0;  ///< of the noise
};

/// The arm in MuJoCo: URDF, meshes and scene composed into one compiled model, stepped by 1 ms.
///
/// tau_J is the torque behind the gear: the applied torque less the rotor's inertial torque,
/// armature * ddq, of the step that ends there; after Reset() it is the torque of gravity. theta
/// equals q (rigid joints). data() holds poses and contacts of the state that sensors() shows.
///
/// A motion that the engine calls unstable (NaN or huge values) halts the arm: sensors() keeps its
/// last sound values, every further Step() only adds to warning_count(), and Reset() makes a new
/// start.
class MujocoPlant : public Plant, public TruthProbe {
 public:
  /// Composes (or takes from the cache) and compiles.
  /// @throws InputError for a bad URDF, mesh or scene, naming file and element; EnvironmentError
  /// for a cache entry that is corrupt or a folder that cannot be written, naming the path and the
  /// cure.
  [[nodiscard]] static std::unique_ptr<MujocoPlant> Create(const MujocoPlantOptions& options);

  /// @returns true when visual and collision shapes come from the mesh package, false for primitive
  /// shapes.
  [[nodiscard]] virtual bool uses_meshes() const noexcept = 0;

  /// @returns the torque that holds the arm against gravity at `q`, from the compiled model (for
  /// checks against our own).
  [[nodiscard]] virtual JointVector GravityTorque(const JointVector& q) = 0;

  /// @returns how often the engine has warned since Create(): while compiling, and in steps. Zero
  /// in every healthy run. Real-time: noexcept, O(1).
  [[nodiscard]] virtual std::uint64_t warning_count() const noexcept = 0;

  /// @returns what it warned of, a line each; empty when warning_count() is zero.
  [[nodiscard]] virtual std::string DescribeWarnings() const = 0;
};

}  // namespace twin::plant

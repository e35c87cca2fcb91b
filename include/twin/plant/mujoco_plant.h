#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/setting.h"
#include "twin/plant/base_body.h"
#include "twin/plant/perturbation.h"
#include "twin/plant/plant.h"
#include "twin/plant/scene_object.h"
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

/// How the motor positions differ from those of the links. Figure and its reason:
/// src/plant/joint_elasticity.h.
enum class ElasticityProfile : std::uint8_t {
  kRigid,   ///< theta = q, dtheta = dq
  kStatic,  ///< gear and torque sensor as a spring without a mass of its own:
            ///< theta = q + tau_J / k_joint, dtheta = dq + dtau_J / k_joint
};

/// Standard deviations of white noise added to the sensors; zero is off.
struct SensorNoise {
  double q_rad = 0;
  double dq_rad_per_s = 0;
  double tau_J_Nm = 0;
};

/// How a base stands out of level, rad, each in [-0.2, 0.2]; about its own axes x and y.
struct BaseTilt {
  double roll = 0;
  double pitch = 0;
  bool operator==(const BaseTilt&) const = default;
};

/// Everything a MuJoCo plant is made of.
struct MujocoPlantOptions {
  std::filesystem::path urdf;   ///< the arm
  std::filesystem::path scene;  ///< MJCF of the world around it; empty: a plain floor and a light
  std::vector<SceneObject> objects;  ///< beside those of the scene
  std::filesystem::path
      mesh_package;  ///< folder of `panda_description`; empty or missing: primitive shapes
  std::filesystem::path cache;  ///< folder of compiled models; empty: no cache
  bool rebuild_cache = false;   ///< ignore and replace what the cache holds
  /// How far the meshes that are drawn may be from those of the package, for fewer triangles, m, in
  /// [0, 0.01]; 0: as they are. What is touched is not concerned (src/render/README.md).
  double visual_error = 0.00025;
  HandKind hand = HandKind::kFrankaHand;
  FrictionProfile friction = FrictionProfile::kResidual;
  bool armature = true;  ///< reflected rotor inertia of the drives
  ElasticityProfile elasticity = ElasticityProfile::kRigid;
  /// Of every link's mass and inertia, arm and hand, against the URDFs'; in [0.5, 2].
  double mass_scale = 1;
  /// Roll and pitch of the base, with all that stands beside it, against gravity, rad: the base is
  /// turned by R = R_y(pitch) R_x(roll) from level. Not beside a mobile base, which stands as its
  /// tyres let it.
  BaseTilt base_tilt;
  /// The mobile base that carries the arm; absent: the arm stands on the world, O in its origin.
  std::optional<BaseOptions> base{};
  /// A body that is really there, fixed to the flange, whether INT is told of it or not. An inertia
  /// of zero stands for that of a ball of steel.
  setting::Load load;
  SensorNoise noise;
  std::uint64_t seed = 0;                   ///< of the noise
  std::vector<Perturbation> perturbations;  ///< forces from outside, by a script
};

/// The arm in MuJoCo: URDF, meshes and scene composed into one compiled model, stepped by 1 ms.
///
/// tau_J is the torque behind the gear: the applied torque (and that of a closed brake) less the
/// rotor's inertial torque, armature * ddq, of the step that ends there; after Reset() it is the
/// torque of gravity. So it contains gravity, the inertia of the links, their friction, contacts
/// and forces from outside. theta follows from it by the elasticity profile. data() holds poses and
/// contacts of the state that sensors() shows.
///
/// Closed brakes hold each joint where it is, whatever the applied torque, up to twice the URDF's
/// effort limit (174 Nm, wrist 24 Nm; not public, our decision): tau_J is then what the links ask
/// for.
///
/// A motion that the engine calls unstable (NaN or huge values) halts the arm: nothing is measured
/// any more (sensors() gives no numbers), every further Step() only adds to warning_count(), and
/// Reset() makes a new start.
class MujocoPlant : public Plant, public TruthProbe {
 public:
  /// Composes (or takes from the cache) and compiles.
  /// @throws InputError for a bad URDF, mesh or scene, naming file and element, and for a bad
  /// load or perturbation or one of a body the model does not have (names those it has);
  /// EnvironmentError for a cache entry that is corrupt or a folder that cannot be written, naming
  /// the path and the cure.
  [[nodiscard]] static std::unique_ptr<MujocoPlant> Create(const MujocoPlantOptions& options);

  /// @returns true when visual and collision shapes come from the mesh package, false for primitive
  /// shapes.
  [[nodiscard]] virtual bool uses_meshes() const noexcept = 0;

  /// @returns the torque that holds the arm against gravity at `q`, from the compiled model (for
  /// checks against our own).
  [[nodiscard]] virtual JointVector GravityTorque(const JointVector& q) = 0;

  /// Adds a force from outside, which acts from the next Step() on and after every Reset() again.
  /// Between steps only; allocates.
  /// @throws InputError when a field is out of range, or the model has no such body (names those it
  /// has).
  virtual void Perturb(const Perturbation& perturbation) = 0;

  /// Takes all forces from outside away, those of the options too. Between steps only.
  virtual void ClearPerturbations() = 0;

  /// @returns time since the last Reset(): 1 ms per step taken. Real-time: noexcept, O(1).
  [[nodiscard]] virtual Duration plant_time() const noexcept = 0;

  /// @returns how often the engine has warned since Create(): while compiling, and in steps. Zero
  /// in every healthy run. Real-time: noexcept, O(1).
  [[nodiscard]] virtual std::uint64_t warning_count() const noexcept = 0;

  /// @returns what it warned of, a line each; empty when warning_count() is zero.
  [[nodiscard]] virtual std::string DescribeWarnings() const = 0;
};

}  // namespace twin::plant

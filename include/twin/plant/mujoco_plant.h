#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/setting.h"
#include "twin/plant/arm_properties.h"
#include "twin/plant/perturbation.h"
#include "twin/plant/plant.h"
#include "twin/plant/scene_object.h"
#include "twin/plant/truth_probe.h"

namespace twin::plant {

/// Friction of the joints. Values and sources: twin/model/arm_model.h
/// and src/plant/joint_parameters.h.
enum class FrictionProfile : std::uint8_t {
  kNone,      ///< frictionless
  kResidual,  ///< residual link-side friction after the robot's own compensation (sigmoid of Gaz et
              ///< al. 2019)
  kBreakaway,  ///< break-away torques measured through the FCI on one Panda (franka_emulator), plus
               ///< viscous friction
};

/// Relation of motor and link positions.
enum class ElasticityProfile : std::uint8_t {
  kRigid,   ///< theta = q, dtheta = dq
  kStatic,  ///< massless spring of gear and torque sensor:
            ///< theta = q + tau_J / k_joint, dtheta = dq + dtau_J / k_joint
};

/// Standard deviations of white noise on the sensors; zero: off.
struct SensorNoise {
  double q_rad = 0;
  double dq_rad_per_s = 0;
  double tau_J_Nm = 0;
};

/// Tilt of the base against level, rad, each in [-0.2, 0.2]; about its own axes x and y.
struct BaseTilt {
  double roll = 0;
  double pitch = 0;
  bool operator==(const BaseTilt&) const = default;
};

/// Where the base O of an arm stands in the world W: upright, turned about z.
struct ArmPose {
  Vector3 position{};  ///< m, each in [-100, 100]
  double yaw = 0;      ///< rad, in [-2 pi, 2 pi]

  /// X_WO.
  [[nodiscard]] Transform Matrix() const noexcept;
  bool operator==(const ArmPose&) const = default;
};

class SharedModel;

/// Options of a MuJoCo plant.
struct MujocoPlantOptions {
  std::filesystem::path urdf;        ///< the arm
  std::filesystem::path scene;       ///< MJCF of the surroundings; empty: a plain floor and a light
  std::vector<SceneObject> objects;  ///< in addition to those of the scene
  std::filesystem::path
      mesh_package;  ///< folder of `panda_description`; empty or missing: primitive shapes
  std::filesystem::path cache;  ///< folder of compiled models; empty: no cache
  bool rebuild_cache = false;   ///< ignore and replace cached models
  /// Largest deviation of drawn meshes from those of the package, for fewer triangles, m, in [0,
  /// 0.01]; 0: unchanged. Contact shapes are not affected (src/render/README.md).
  double visual_error = 0.00025;
  HandKind hand = HandKind::kFrankaHand;
  FrictionProfile friction = FrictionProfile::kResidual;
  bool armature = true;  ///< reflected rotor inertia of the drives
  ElasticityProfile elasticity = ElasticityProfile::kRigid;
  ArmProperties arm;
  /// Factor on mass and inertia of every link, arm and hand, of the URDFs; in [0.5, 2].
  double mass_scale = 1;
  /// Roll and pitch of the base with its surroundings against gravity, rad: the base is rotated by
  /// R = R_y(pitch) R_x(roll) from level. Not with a mobile base, whose tyres set its tilt.
  BaseTilt base_tilt;
  /// Of O in the world, of an arm without a mobile base.
  ArmPose pose;
  /// Begins the names of the arm's bodies, joints and shapes in a model of several arms: "left/".
  std::string prefix;
  /// The model of several arms in which this one has the place of `prefix`; null: a model of its
  /// own.
  std::shared_ptr<SharedModel> shared{};
  /// The mobile base that carries the arm; absent: the arm is fixed to the world, at `pose`.
  std::optional<BaseOptions> base{};
  /// A body fixed to the flange, independent of INT's configured load. Zero inertia means that of a
  /// steel ball.
  setting::Load load;
  SensorNoise noise;
  std::uint64_t seed = 0;                   ///< of the noise
  std::vector<Perturbation> perturbations;  ///< scripted external forces
};

/// The arm in MuJoCo: URDF, meshes and scene in one compiled model, stepped by 1 ms.
///
/// tau_J is the torque behind the gear: the applied torque (and that of a closed brake) less the
/// rotor's inertial torque, armature * ddq, of the last step; after Reset() the gravity torque. So
/// it contains gravity, link inertia, link friction, contacts and external forces. theta follows
/// from it by the elasticity profile, and sensors().tau_J by the sensors' delay. data() holds poses
/// and contacts for the state in sensors().
///
/// Closed brakes hold each joint in place under any applied torque up to twice the URDF's effort
/// limit (174 Nm, wrist 24 Nm; not public, a decision); tau_J is then the load of the links.
///
/// An unstable motion by the engine's criterion (NaN or huge values) stops the arm: sensors()
/// returns NaN, every further Step() only increments warning_count(), and Reset() restarts.
class MujocoPlant : public Plant, public TruthProbe {
 public:
  /// Composes (or loads from the cache) and compiles; takes its place in options.shared, if there
  /// is one.
  /// @throws InputError for a bad URDF, mesh or scene, naming file and element, and for a bad load
  /// or perturbation, or one of an unknown body (listing the known ones); EnvironmentError for a
  /// corrupt cache entry or a folder that is not writable, naming the path and the cure.
  [[nodiscard]] static std::unique_ptr<MujocoPlant> Create(const MujocoPlantOptions& options);

  /// @returns true if visual and collision shapes come from the mesh package, false for primitive
  /// shapes.
  [[nodiscard]] virtual bool uses_meshes() const noexcept = 0;

  /// @returns the gravity torque at `q`, from the compiled model (for checks against ArmModel).
  [[nodiscard]] virtual JointVector GravityTorque(const JointVector& q) = 0;

  /// Adds an external force from the next Step() on, also after every Reset(). Between steps only;
  /// allocates.
  /// @throws InputError if a field is out of range, or for an unknown body (listing the known
  /// ones).
  virtual void Perturb(const Perturbation& perturbation) = 0;

  /// Removes all external forces, including those of the options. Between steps only.
  virtual void ClearPerturbations() = 0;

  /// Gives a body another mass, and inertias in proportion; no Reset() or Restore() takes that
  /// back. Between steps only; allocates. @param body  as BodyNamed() has it. @param mass  kg.
  /// @throws InputError unless the body has a mass and `mass` is in [0.001, 100].
  virtual void SetMass(int body, double mass) = 0;

  /// Gives all shapes of a body another sliding friction; otherwise as SetMass().
  /// @throws InputError unless `friction` is in [0, 10].
  virtual void SetFriction(int body, double friction) = 0;

  /// @returns time since the last Reset(): 1 ms per step taken. Real-time: noexcept, O(1).
  [[nodiscard]] virtual Duration plant_time() const noexcept = 0;

  /// @returns the number of engine warnings since Create(), from compiling and steps. Zero in every
  /// healthy run. Real-time: noexcept, O(1).
  [[nodiscard]] virtual std::uint64_t warning_count() const noexcept = 0;

  /// @returns the warnings, one per line; empty when warning_count() is zero.
  [[nodiscard]] virtual std::string DescribeWarnings() const = 0;
};

}  // namespace twin::plant

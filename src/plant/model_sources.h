#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "plant/file_bytes.h"
#include "plant/robot_description.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// A mesh file with its content.
struct MeshFile {
  std::filesystem::path file;
  std::string bytes;
};

/// One arm of a model.
struct ArmSources {
  RobotDescription robot;  ///< arm and hand
  FrictionProfile friction = FrictionProfile::kNone;
  JointVector armature{};  ///< inertia of the rotors, kg m^2
};

/// All inputs of a model, read but not yet composed.
struct ModelSources {
  std::vector<ArmSources> arms;            ///< at least one
  std::map<std::string, MeshFile> meshes;  ///< by URI in the URDF
  bool uses_meshes = false;
  double visual_error = 0;           ///< see MujocoPlantOptions
  std::string scene_text;            ///< MJCF
  std::string objects_text;          ///< MJCF of the objects' bodies
  std::filesystem::path scene_file;  ///< empty: the built-in scene
  bool scene_is_self_contained =
      true;         ///< false: it refers to further files, which the key does not cover
  std::string key;  ///< hash of all of the above, MuJoCo's version and the composition
};

/// Reads the files in the options of a model's arms; what is not an arm's own is in the first. The
/// hand is `../hand/hand.urdf`, the cobot pump `../cobot_pump/cobot_pump.urdf`, and primitive
/// shapes are in `primitives.yaml` beside each URDF that names meshes.
/// @throws InputError naming file and element for anything unreadable, unsupported or missing.
[[nodiscard]] ModelSources ReadModelSources(std::span<const MujocoPlantOptions> arms);

/// Reads and hashes a mobile base's URDF, with primitive shapes only. Its root gets a free joint,
/// at the height above the floor that its wheels define.
/// @throws InputError naming file and element if it violates BaseOptions.
[[nodiscard]] RobotDescription ReadBase(const std::filesystem::path& urdf, ContentHash& hash);

}  // namespace twin::plant

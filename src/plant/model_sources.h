#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "plant/file_bytes.h"
#include "plant/robot_description.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// A mesh file with its content.
struct MeshFile {
  std::filesystem::path file;
  std::string bytes;
};

/// All inputs of a model, read but not yet composed.
struct ModelSources {
  RobotDescription robot;                  ///< arm and hand
  std::map<std::string, MeshFile> meshes;  ///< by URI in the URDF
  bool uses_meshes = false;
  double visual_error = 0;           ///< see MujocoPlantOptions
  std::string scene_text;            ///< MJCF
  std::string objects_text;          ///< MJCF of the objects' bodies
  std::filesystem::path scene_file;  ///< empty: the built-in scene
  bool scene_is_self_contained =
      true;  ///< false: it refers to further files, which the key does not cover
  FrictionProfile friction = FrictionProfile::kNone;
  JointVector armature{};  ///< inertia of the rotors, kg m^2
  std::string key;         ///< hash of all of the above, MuJoCo's version and the composition
};

/// Reads the files in `options`. The hand is `../hand/hand.urdf` and primitive shapes are in
/// `primitives.yaml`, beside each URDF.
/// @throws InputError naming file and element for anything unreadable, unsupported or missing.
[[nodiscard]] ModelSources ReadModelSources(const MujocoPlantOptions& options);

/// Reads and hashes a mobile base's URDF, with primitive shapes only. Its root gets a free joint,
/// at the height above the floor that its wheels define.
/// @throws InputError naming file and element if it violates BaseOptions.
[[nodiscard]] RobotDescription ReadBase(const std::filesystem::path& urdf, ContentHash& hash);

}  // namespace twin::plant

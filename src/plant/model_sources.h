#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "plant/robot_description.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// A mesh file as it was read.
struct MeshFile {
  std::filesystem::path file;
  std::string bytes;
};

/// Everything a model is made of, read but not yet composed.
struct ModelSources {
  RobotDescription robot;                  ///< arm and hand
  std::map<std::string, MeshFile> meshes;  ///< by the URI the URDF uses
  bool uses_meshes = false;
  double visual_error = 0;           ///< see MujocoPlantOptions
  std::string scene_text;            ///< MJCF
  std::string objects_text;          ///< MJCF of the objects' bodies
  std::filesystem::path scene_file;  ///< empty: the built-in scene
  bool scene_is_self_contained =
      true;  ///< false: it names further files, which the key does not cover
  FrictionProfile friction = FrictionProfile::kNone;
  bool armature = false;
  std::string key;  ///< fingerprint of all of the above, of MuJoCo and of our composition
};

/// Reads what `options` name. The hand is `../hand/hand.urdf` and the primitive shapes are
/// `primitives.yaml`, both beside the URDF concerned.
/// @throws InputError naming file and element for anything unreadable, unsupported or missing.
[[nodiscard]] ModelSources ReadModelSources(const MujocoPlantOptions& options);

}  // namespace twin::plant

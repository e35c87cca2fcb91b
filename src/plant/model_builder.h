#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "plant/model_sources.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

struct ModelDeleter {
  void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
};
using ModelPointer = std::unique_ptr<mjModel, ModelDeleter>;

struct DataDeleter {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};
using DataPointer = std::unique_ptr<mjData, DataDeleter>;

/// A compiled model and the engine's warnings from compilation.
struct BuiltModel {
  ModelPointer model;
  std::vector<std::string> warnings;
};

/// Imports the meshes, composes and compiles.
/// @throws InputError naming file and element for a bad mesh or scene, or for a scene with compiler
/// settings that would change the robot.
[[nodiscard]] BuiltModel BuildModel(const ModelSources& sources);

/// @returns the model in MuJoCo's binary form.
[[nodiscard]] std::string SerializeModel(const mjModel& model);

/// @param bytes  unchanged from SerializeModel().
/// @throws EnvironmentError if the engine nevertheless cannot load them.
[[nodiscard]] ModelPointer DeserializeModel(const std::string& bytes);

/// Installs the error handlers, and checks that MuJoCo's version is that of the build.
/// @throws EnvironmentError if it differs.
void PrepareEngine();

/// Loads the model from the cache in `options`, or builds and stores it. @param options  of its
/// first arm.
/// @pre PrepareEngine(). @throws as BuildModel() and ModelCache.
[[nodiscard]] BuiltModel LoadOrBuild(const MujocoPlantOptions& options,
                                     const ModelSources& sources);

}  // namespace twin::plant

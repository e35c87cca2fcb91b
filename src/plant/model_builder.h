#pragma once

#include <memory>
#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "plant/model_sources.h"

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

}  // namespace twin::plant

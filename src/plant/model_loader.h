#pragma once

#include "plant/model_builder.h"
#include "plant/model_sources.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// Installs the error handlers, and checks that MuJoCo's version is that of the build.
/// @throws EnvironmentError if it differs.
void PrepareEngine();

/// Loads the model from the cache in `options`, or builds and stores it.
/// @pre PrepareEngine(). @throws as BuildModel() and ModelCache.
[[nodiscard]] BuiltModel LoadOrBuild(const MujocoPlantOptions& options,
                                     const ModelSources& sources);

}  // namespace twin::plant

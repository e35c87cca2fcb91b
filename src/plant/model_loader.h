#pragma once

#include "plant/model_builder.h"
#include "plant/model_sources.h"
#include "twin/plant/mujoco_plant.h"

namespace twin::plant {

/// Makes MuJoCo's failures ours, and checks that the library is the one this was built for.
/// @throws EnvironmentError when it is another.
void PrepareEngine();

/// Takes the model from the cache that `options` name, or builds it and leaves it there.
/// @pre PrepareEngine(). @throws as BuildModel() and ModelCache.
[[nodiscard]] BuiltModel LoadOrBuild(const MujocoPlantOptions& options,
                                     const ModelSources& sources);

}  // namespace twin::plant

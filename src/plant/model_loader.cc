#include "plant/model_loader.h"

#include <fmt/format.h>

#include "plant/base_joints.h"
#include "plant/model_cache.h"
#include "plant/scene_objects.h"
#include "twin/core/error.h"
#include "twin/plant/engine.h"

namespace twin::plant {

void PrepareEngine() {
  InstallEngineHandlers();
  if (mj_version() != mjVERSION_HEADER) {
    throw EnvironmentError(
        fmt::format("MuJoCo {} is installed, but this program was built for {}; rebuild it, or "
                    "install that one",
                    mj_version(), mjVERSION_HEADER));
  }
}

namespace {

/// With the objects of the first compilation, by any process.
BuiltModel Fetch(const MujocoPlantOptions& options, const ModelSources& sources) {
  if (options.cache.empty() || !sources.scene_is_self_contained) return BuildModel(sources);
  const ModelCache cache(options.cache);
  if (!options.rebuild_cache) {
    if (const auto bytes = cache.Load(sources.key)) {
      try {
        return {DeserializeModel(*bytes), {}};
      } catch (const EnvironmentError&) {
        // Complete, but not loadable by this engine: compile and replace it.
      }
    }
  }
  BuiltModel built = BuildModel(sources);
  // A model with warnings is recompiled each time, so that they appear each time.
  if (built.warnings.empty()) cache.Store(sources.key, SerializeModel(*built.model));
  return built;
}

}  // namespace

BuiltModel LoadOrBuild(const MujocoPlantOptions& options, const ModelSources& sources) {
  BuiltModel built = Fetch(options, sources);
  if (options.base) PlaceBase(options.base->start, sources.robot, *built.model);
  ShapeObjects(options.objects, *built.model);
  return built;
}

}  // namespace twin::plant

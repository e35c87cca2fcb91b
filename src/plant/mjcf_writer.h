#pragma once

#include <map>
#include <string>
#include <vector>

#include "plant/model_sources.h"

namespace twin::plant {

/// A mesh in the engine's format.
struct MeshAsset {
  std::string file;  ///< name in the virtual file system
  std::string msh;   ///< content
  Colour colour{1, 1, 1, 1};
};

/// Assets by mesh URI, split by colour.
using MeshAssets = std::map<std::string, std::vector<MeshAsset>>;

/// Name of the scene in the virtual file system.
inline constexpr const char* kSceneFile = "panda_twin_scene.xml";

/// Writes the model as MJCF: one body per link, with its name; collision shapes in group 3, visual
/// ones in group 2; then the scene, included; the step of 1 ms last, so that no scene changes it.
///
/// Joint ranges are written as [-1, 1], since their unit depends on the scene's compiler settings;
/// the true ones are set in the compiled model.
[[nodiscard]] std::string WriteMjcf(const ModelSources& sources, const MeshAssets& visual,
                                    const MeshAssets& collision);

}  // namespace twin::plant

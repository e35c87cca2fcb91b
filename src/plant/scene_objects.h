#pragma once

#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "twin/plant/scene_object.h"

namespace twin::plant {

/// The objects' bodies as MJCF for a <worldbody>: their names, and which of them move.
/// ShapeObjects() sets all else, so that one compiled model serves any sizes, masses and poses.
[[nodiscard]] std::string ObjectsMjcf(const std::vector<SceneObject>& objects);

/// The objects' part of a compiled model's key; empty without objects.
[[nodiscard]] std::string ObjectsKey(const std::vector<SceneObject>& objects);

/// Sets shapes, masses and poses of the objects in a model and updates the engine's derived values.
/// @pre valid objects, those of the model.
void ShapeObjects(const std::vector<SceneObject>& objects, mjModel& model);

}  // namespace twin::plant

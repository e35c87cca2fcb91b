#pragma once

#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "twin/plant/scene_object.h"

namespace twin::plant {

/// The objects' bodies as MJCF, to stand in a <worldbody>: their names, and which of them move.
/// Everything else of them is ShapeObjects()' to set, so that one compiled model serves whatever
/// sizes, masses and poses they have.
[[nodiscard]] std::string ObjectsMjcf(const std::vector<SceneObject>& objects);

/// What of the objects goes into a compiled model, for its key; empty when there are none.
[[nodiscard]] std::string ObjectsKey(const std::vector<SceneObject>& objects);

/// Gives the bodies of a model that has them their shapes, masses and poses, and computes anew what
/// the engine derives of those. @pre valid objects, the model's own.
void ShapeObjects(const std::vector<SceneObject>& objects, mjModel& model);

}  // namespace twin::plant

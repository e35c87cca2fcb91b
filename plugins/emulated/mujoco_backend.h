#pragma once

#include "twin/backend/registry.h"

namespace twin::plugins {

/// Adds the backend "mujoco": the emulated robot in process, on the virtual clock or on the wall
/// clock as the request's host says, with the plant the robot's configuration asks for (MuJoCo, or
/// the ideal plant).
void RegisterMujoco(backend::Registry& registry);

}  // namespace twin::plugins

#pragma once

#include "twin/backend/registry.h"

namespace twin::plugins {

/// Adds the backend "mujoco": the emulated robot in this process, on the virtual or the wall clock
/// by the request's time, with the plant of the robot's configuration (MuJoCo, or the ideal plant).
void RegisterMujoco(backend::Registry& registry);

}  // namespace twin::plugins

#pragma once

#include <memory>

#include "plugins/mujoco/emulated_backend.h"
#include "twin/backend/registry.h"

namespace twin::plugins {

/// The emulated robot on the virtual clock: its cycles are events of the host's queue, from now on.
[[nodiscard]] std::unique_ptr<backend::Backend> MakeLockstepBackend(
    const backend::Request& request, const backend::LockstepHost& host, NamedPlant plant);

}  // namespace twin::plugins

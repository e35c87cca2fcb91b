#pragma once

#include "plugins/emulated/emulated_backend.h"
#include "twin/backend/registry.h"

namespace twin::plugins {

/// Connects the emulated robot on the virtual clock: its cycles are events of the queue from now
/// on. Sets backend and panel of the connection.
void ConnectLockstep(const backend::Request& request, const backend::VirtualTime& time,
                     NamedPlant plant, backend::Connection& connection);

}  // namespace twin::plugins

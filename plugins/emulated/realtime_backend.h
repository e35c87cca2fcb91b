#pragma once

#include "plugins/emulated/emulated_backend.h"
#include "twin/backend/registry.h"

namespace twin::plugins {

/// Connects the emulated robot on the wall clock, on its own thread, which runs between Begin() and
/// End() of the connection's robot_time. Sets backend, panel, arrival and robot_time.
void ConnectRealtime(const backend::Request& request, const backend::WallTime& time,
                     NamedPlant plant, backend::Connection& connection);

}  // namespace twin::plugins

#pragma once

#include "plugins/emulated/emulated_backend.h"
#include "twin/backend/registry.h"

namespace twin::plugins {

/// The emulated robot on the wall clock, on a thread of its own that runs between Begin() and End()
/// of the connection's robot_time. Fills in backend, panel, arrival and robot_time.
void ConnectRealtime(const backend::Request& request, const backend::RealtimeHost& host,
                     NamedPlant plant, backend::Connection& connection);

}  // namespace twin::plugins

#pragma once

#include "twin/backend/registry.h"

namespace twin::plugins {

/// The backend "fci": a robot at the other end of a wire that speaks the Franka Control Interface,
/// version 5: a Panda, or a twin served by `panda-twin serve`. It needs no library of the vendor's,
/// and runs no code that the robot serves.
///
/// Its arrival is the states' socket. Of panel, truth and cycles it knows nothing; the hand is
/// there when the request's robot has one.
///
/// @throws InputError when the request's host is no RemoteHost, or its address is none; RobotFault
/// when the robot cannot be reached, or speaks another version.
[[nodiscard]] backend::Connection ConnectFci(const backend::Request& request);

/// Adds it.
void RegisterFci(backend::Registry& registry);

}  // namespace twin::plugins

#pragma once

#include "twin/backend/registry.h"

namespace twin::plugins {

/// Adds the backend "mujoco": the emulated robot in this process, on the virtual or the wall clock
/// by the request's time, with the plant of the robot's configuration (MuJoCo, or the ideal plant).
void RegisterMujoco(backend::Registry& registry);

/// The backend "fci": a remote robot that speaks the Franka Control Interface, version 5: a Panda,
/// or a twin served by `panda-twin serve`. It needs no vendor library and runs no code from the
/// robot.
///
/// Its arrival is the state socket. It has no panel, truth or cycle records; it has a hand if the
/// request's robot has one.
///
/// @throws InputError if the request's time is not a RemoteRobot, or its address is invalid;
/// RobotFault if the robot cannot be reached or speaks another version.
[[nodiscard]] backend::Connection ConnectFci(const backend::Request& request);

/// Adds the backend "fci".
void RegisterFci(backend::Registry& registry);

}  // namespace twin::plugins

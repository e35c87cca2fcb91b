#pragma once

#include <filesystem>
#include <optional>

#include "twin/fci/sockets.h"

// Unix sockets, streams of bytes within this machine.
namespace twin::server {

/// Listens at a path, for this user alone, without blocking. Replaces the socket of a program that
/// has ended.
/// @throws InputError when the path is too long or names another file than a socket;
/// EnvironmentError when a program listens there, or the socket cannot be created.
[[nodiscard]] fci::FileDescriptor ListenAt(const std::filesystem::path& path);

/// Connects, blocking. @returns nullopt when no program listens there.
/// @throws InputError when the path is too long.
[[nodiscard]] std::optional<fci::FileDescriptor> ConnectTo(const std::filesystem::path& path);

}  // namespace twin::server

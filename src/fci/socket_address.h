#pragma once

#include <netinet/in.h>

#include <string>

#include "twin/fci/sockets.h"

// Addresses as the system's calls take and give them, and what its refusals mean to people.
namespace twin::fci {

[[nodiscard]] sockaddr_in AddressOf(const Endpoint& endpoint) noexcept;
[[nodiscard]] Endpoint EndpointOf(const sockaddr_in& address) noexcept;

/// Where a socket is bound; 0.0.0.0:0 when the system does not tell.
[[nodiscard]] Endpoint LocalEndpoint(int fd) noexcept;
/// To where a socket is connected; 0.0.0.0:0 when it is not, or not any more.
[[nodiscard]] Endpoint PeerEndpoint(int fd) noexcept;

/// The system's words for `error`, an errno.
[[nodiscard]] std::string ReasonOf(int error);

/// @param type  SOCK_STREAM or SOCK_DGRAM.
/// @returns a socket that does not block and is not inherited. @throws EnvironmentError.
[[nodiscard]] FileDescriptor OpenSocket(int type);

/// @throws EnvironmentError: the port is taken, the address is none of this machine's.
void Bind(int fd, const Endpoint& local);

/// Switches a socket's option; a socket that refuses works without it.
void SetOption(int fd, int level, int option, int value) noexcept;

}  // namespace twin::fci

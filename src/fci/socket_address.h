#pragma once

#include <netinet/in.h>

#include <string>

#include "twin/fci/sockets.h"

// Addresses in the form of the system calls, and users' texts for their errors.
namespace twin::fci {

[[nodiscard]] sockaddr_in AddressOf(const Endpoint& endpoint) noexcept;
[[nodiscard]] Endpoint EndpointOf(const sockaddr_in& address) noexcept;

/// Address to which a socket is bound; 0.0.0.0:0 if the system gives none.
[[nodiscard]] Endpoint LocalEndpoint(int fd) noexcept;
/// Address to which a socket is connected; 0.0.0.0:0 if it is not, or no longer is.
[[nodiscard]] Endpoint PeerEndpoint(int fd) noexcept;

/// The system's text for `error`, an errno.
[[nodiscard]] std::string ReasonOf(int error);

/// @param type  SOCK_STREAM or SOCK_DGRAM.
/// @returns a non-blocking socket that child processes do not inherit. @throws EnvironmentError.
[[nodiscard]] FileDescriptor OpenSocket(int type);

/// @param error  the errno by which `local` cannot be listened at.
[[noreturn]] void ThrowNotListening(const Endpoint& local, int error);

/// @throws EnvironmentError if the port is in use or the address is not this machine's.
void Bind(int fd, const Endpoint& local);

/// Sets a socket option; ignores failure, because the socket works without it.
void SetOption(int fd, int level, int option, int value) noexcept;

}  // namespace twin::fci

#include "fci/socket_address.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <cerrno>
#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::fci {
namespace {

/// @param ask  getsockname or getpeername.
Endpoint Ask(int (*ask)(int, sockaddr*, socklen_t*) noexcept, int fd) noexcept {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (ask(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  return EndpointOf(address);
}

std::string_view CureOf(int error) noexcept {
  if (error == EADDRINUSE) return "end the program that uses it, or take another port or address";
  if (error == EADDRNOTAVAIL) return "take an address of this machine (`ip address` lists them)";
  if (error == EACCES) return "take a port above 1023";
  return "look at the machine's network";
}

}  // namespace

sockaddr_in AddressOf(const Endpoint& endpoint) noexcept {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(endpoint.address);
  address.sin_port = htons(endpoint.port);
  return address;
}

Endpoint EndpointOf(const sockaddr_in& address) noexcept {
  return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

Endpoint LocalEndpoint(int fd) noexcept {
  return Ask(getsockname, fd);
}

Endpoint PeerEndpoint(int fd) noexcept {
  return Ask(getpeername, fd);
}

std::string ReasonOf(int error) {
  return std::system_category().message(error);
}

FileDescriptor OpenSocket(int type) {
  FileDescriptor fd(socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!fd.valid()) {
    throw EnvironmentError(
        fmt::format("no socket could be opened: {}; raise the limit of open files (`ulimit -n`)",
                    ReasonOf(errno)));
  }
  return fd;
}

void ThrowNotListening(const Endpoint& local, int error) {
  throw EnvironmentError(fmt::format("{} cannot be listened at: {}; {}", ToString(local),
                                     ReasonOf(error), CureOf(error)));
}

void Bind(int fd, const Endpoint& local) {
  const sockaddr_in address = AddressOf(local);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  ThrowNotListening(local, errno);
}

void SetOption(int fd, int level, int option, int value) noexcept {
  static_cast<void>(setsockopt(fd, level, option, &value, sizeof value));
}

}  // namespace twin::fci

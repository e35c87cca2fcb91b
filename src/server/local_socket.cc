#include "server/local_socket.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::server {
namespace {

sockaddr_un AddressOf(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string& name = path.native();
  if (name.empty() || name.size() >= sizeof(address.sun_path)) {
    throw InputError(
        fmt::format("the path of a control channel has {} bytes; it may have 1 to {}: "
                    "\"{}\"",
                    name.size(), sizeof(address.sun_path) - 1, name));
  }
  std::ranges::copy(name, address.sun_path);
  return address;
}

[[noreturn]] void FailAt(const std::filesystem::path& path) {
  throw EnvironmentError(
      fmt::format("{}: no control channel can be opened there ({}); name a file "
                  "in a folder of your own",
                  path.string(), std::generic_category().message(errno)));
}

/// Removes the socket of a program that has ended.
void MakeRoom(const std::filesystem::path& path) {
  struct stat there {};
  if (lstat(path.c_str(), &there) != 0) return;
  if (!S_ISSOCK(there.st_mode)) {
    throw InputError(
        fmt::format("{}: it exists and is not a socket; name another file", path.string()));
  }
  if (ConnectTo(path)) {
    throw EnvironmentError(
        fmt::format("{}: another server has its control channel there", path.string()));
  }
  unlink(path.c_str());
}

fci::FileDescriptor NewSocket(int flags) {
  return fci::FileDescriptor(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0));
}

}  // namespace

fci::FileDescriptor ListenAt(const std::filesystem::path& path) {
  constexpr int kWaiting = 8;
  const sockaddr_un address = AddressOf(path);
  MakeRoom(path);
  fci::FileDescriptor listener = NewSocket(SOCK_NONBLOCK);
  const auto* const name = reinterpret_cast<const sockaddr*>(&address);
  // The socket's file gets these permissions when it is bound.
  if (!listener.valid() || fchmod(listener.get(), S_IRUSR | S_IWUSR) != 0 ||
      bind(listener.get(), name, sizeof(address)) != 0 || listen(listener.get(), kWaiting) != 0) {
    FailAt(path);
  }
  return listener;
}

std::optional<fci::FileDescriptor> ConnectTo(const std::filesystem::path& path) {
  const sockaddr_un address = AddressOf(path);
  fci::FileDescriptor connected = NewSocket(0);
  const auto* const name = reinterpret_cast<const sockaddr*>(&address);
  if (!connected.valid() || connect(connected.get(), name, sizeof(address)) != 0) return {};
  return connected;
}

}  // namespace twin::server

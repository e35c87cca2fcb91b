#include <sys/socket.h>

#include <cerrno>

#include <fmt/format.h>

#include "fci/socket_address.h"
#include "twin/core/error.h"
#include "twin/fci/sockets.h"

namespace twin::fci {
namespace {

/// Connections that may wait for Accept().
constexpr int kBacklog = 16;

}  // namespace

TcpListener::TcpListener(const Endpoint& local) : fd_(OpenSocket(SOCK_STREAM)) {
  // Allows reuse of a port whose last connections are in TIME_WAIT.
  SetOption(fd_.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  Bind(fd_.get(), local);
  if (listen(fd_.get(), kBacklog) == 0) return;
  ThrowNotListening(local, errno);
}

Endpoint TcpListener::local() const {
  return LocalEndpoint(fd_.get());
}

std::optional<TcpStream> TcpListener::Accept() {
  FileDescriptor fd(accept4(fd_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (fd.valid()) return TcpStream(std::move(fd));
  if (errno == EMFILE || errno == ENFILE) {
    throw EnvironmentError(fmt::format(
        "a connection cannot be accepted: {}; raise the limit of open files (`ulimit -n`)",
        ReasonOf(errno)));
  }
  // No connection waits, or the waiting one has closed.
  return {};
}

}  // namespace twin::fci

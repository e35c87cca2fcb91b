#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <fmt/format.h>

#include "fci/socket_address.h"
#include "twin/core/error.h"
#include "twin/fci/sockets.h"

namespace twin::fci {
namespace {

/// Upper bound of reads in Close() before it closes anyway.
constexpr int kMostDrained = 64;

/// Waits until `fd` has connected or failed.
/// @returns false after `timeout`.
bool AwaitConnection(int fd, Duration timeout) {
  const MonotonicClock clock;
  pollfd waiting{fd, POLLOUT, 0};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(
        std::clamp(timeout - clock.Now().time_since_epoch(), Duration::zero(),
                   Duration(std::chrono::hours(24))));
    const int ready = poll(&waiting, 1, static_cast<int>(left.count()));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

/// @returns 0 on success, ETIMEDOUT after `timeout`, or another errno.
int ConnectWithin(int fd, const Endpoint& to, Duration timeout) {
  const sockaddr_in address = AddressOf(to);
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return 0;
  // An interrupted connect continues in the kernel.
  if (errno != EINPROGRESS && errno != EINTR) return errno;
  if (!AwaitConnection(fd, timeout)) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  if (getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0) return errno;
  return error;
}

[[noreturn]] void FailToConnect(const Endpoint& to, int error, Duration timeout) {
  if (error == ECONNREFUSED) {
    throw RobotFault(
        fmt::format("{} refuses the connection; check that it is the robot's address, that "
                    "its control interface (FCI) is activated, or that `panda-twin serve` runs",
                    ToString(to)));
  }
  if (error == ETIMEDOUT) {
    throw RobotFault(
        fmt::format("{} does not answer within {} s; check address, cable and firewall",
                    ToString(to), ToSeconds(timeout)));
  }
  throw RobotFault(fmt::format("{} cannot be reached: {}; check address and network", ToString(to),
                               ReasonOf(error)));
}

/// Result of a call that returned `count`. @param moved  bytes transferred.
StreamResult Judge(ssize_t count, std::size_t& moved) noexcept {
  moved = count > 0 ? static_cast<std::size_t>(count) : 0;
  if (count >= 0) return StreamResult::kDone;
  return errno == EAGAIN || errno == EINTR ? StreamResult::kPending : StreamResult::kReset;
}

}  // namespace

TcpStream::TcpStream(FileDescriptor fd)
    : fd_(std::move(fd)), local_(LocalEndpoint(fd_.get())), peer_(PeerEndpoint(fd_.get())) {
  if (fcntl(fd_.get(), F_SETFL, O_NONBLOCK) != 0) {
    throw EnvironmentError(
        fmt::format("a TCP connection cannot be used without blocking: {}", ReasonOf(errno)));
  }
  SetOption(fd_.get(), IPPROTO_TCP, TCP_NODELAY, 1);
  SetOption(fd_.get(), SOL_SOCKET, SO_KEEPALIVE, 1);
  SetOption(fd_.get(), IPPROTO_TCP, TCP_KEEPIDLE, 1);
  SetOption(fd_.get(), IPPROTO_TCP, TCP_KEEPINTVL, 1);
  SetOption(fd_.get(), IPPROTO_TCP, TCP_KEEPCNT, 3);
}

TcpStream TcpStream::Connect(const Endpoint& to, Duration timeout) {
  FileDescriptor fd = OpenSocket(SOCK_STREAM);
  const int error = ConnectWithin(fd.get(), to, timeout);
  if (error != 0) FailToConnect(to, error, timeout);
  return TcpStream(std::move(fd));
}

StreamResult TcpStream::Receive(std::span<std::byte> room, std::size_t& received) noexcept {
  received = 0;
  if (room.empty()) return StreamResult::kPending;
  const auto count = recv(fd_.get(), room.data(), room.size(), MSG_DONTWAIT);
  return count == 0 ? StreamResult::kClosed : Judge(count, received);
}

StreamResult TcpStream::Send(std::span<const std::byte> bytes, std::size_t& sent) noexcept {
  const auto count = send(fd_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  return Judge(count, sent);
}

void TcpStream::Close() noexcept {
  if (!fd_.valid()) return;
  shutdown(fd_.get(), SHUT_WR);
  // Linux resets a connection closed with unread bytes, and the peer would lose the last data sent.
  std::array<std::byte, 1024> waste;
  for (int i = 0; i < kMostDrained; ++i) {
    if (recv(fd_.get(), waste.data(), waste.size(), MSG_DONTWAIT) <= 0) break;
  }
  fd_.Reset();
}

void TcpStream::ResetConnection() noexcept {
  if (!fd_.valid()) return;
  const linger at_once{1, 0};
  setsockopt(fd_.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  fd_.Reset();
}

}  // namespace twin::fci

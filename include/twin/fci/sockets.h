#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "twin/core/clock.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/record/packet.h"
#include "twin/rt/signal.h"

// IPv4 sockets for the Franka Control Interface. No call blocks unless its comment says so. Errors:
// EnvironmentError or InputError with address, reason and cure.
struct pollfd;

namespace twin::fci {

/// Closes a file descriptor. Threads: one.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) noexcept : fd_(fd) {}
  ~FileDescriptor() { Reset(); }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.Release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  [[nodiscard]] int get() const noexcept { return fd_; }
  [[nodiscard]] bool valid() const noexcept { return fd_ >= 0; }
  int Release() noexcept;
  void Reset() noexcept;

 private:
  int fd_ = -1;
};

/// IPv4 address and port.
using Endpoint = record::PacketEnd;

/// True for the loopback network, 127.0.0.0/8.
[[nodiscard]] constexpr bool IsLoopback(std::uint32_t address) noexcept {
  return address >> 24 == 127;
}

/// "127.0.0.1".
[[nodiscard]] std::string AddressText(std::uint32_t address);
/// "127.0.0.1:1337".
[[nodiscard]] std::string ToString(const Endpoint& endpoint);
/// @param host  an IPv4 address or a name. May block in the resolver. @throws InputError naming it.
[[nodiscard]] Endpoint Resolve(const std::string& host, std::uint16_t port);

/// A network: "192.168.1.0/24".
struct Network {
  std::uint32_t address = 0;
  std::uint32_t mask = 0;
  [[nodiscard]] bool Contains(std::uint32_t other) const noexcept {
    return (other & mask) == address;
  }
};
/// @throws InputError naming the mistake.
[[nodiscard]] Network ParseNetwork(const std::string& text);

/// Waits until one of several descriptors is ready, or until `deadline`.
/// @param waited  as for poll(2). @returns true if one is ready. Real-time: noexcept, bounded by
/// the deadline, does not allocate.
[[nodiscard]] bool AwaitAny(std::span<pollfd> waited, const MonotonicClock& clock,
                            Time deadline) noexcept TWIN_REALTIME;

/// A received datagram.
struct Datagram {
  std::span<const std::byte> bytes;  ///< points into the caller's buffer
  Endpoint from;
  /// Kernel receive time, on the clock of the socket; limited to at most rt::kOldestStamp before
  /// now and never after now. If the kernel gives none: now.
  Time at{};
};

/// A non-blocking UDP socket; also an Arrival that a thread can wait for.
/// Threads: one receives, one sends (may be the same). Real-time: Receive, Send and AwaitUntil are
/// noexcept and do not allocate.
class UdpSocket final : public rt::Arrival {
 public:
  /// Binds `local` (port 0: any free one). @throws EnvironmentError.
  UdpSocket(const MonotonicClock& clock, const Endpoint& local);

  [[nodiscard]] Endpoint local() const noexcept { return local_; }
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }

  /// @returns the next queued datagram, cut to `buffer`; nullopt if none is queued.
  [[nodiscard]] std::optional<Datagram> Receive(std::span<std::byte> buffer) noexcept TWIN_REALTIME;
  /// Makes the kernel drop datagrams from other sources, before they take queue space or wake a
  /// waiting thread, so that foreign traffic cannot delay the peer's. Datagrams already queued
  /// remain. A kernel without socket filters lets everything in. The last call counts. Port 0:
  /// drops everything. Costs a system call. @note A filter instead of connect(2): connect would
  /// bind a wildcard socket to one local address for good, and would let the peer's ICMP errors
  /// fail sends.
  void ListenOnlyTo(const Endpoint& peer) noexcept TWIN_REALTIME;
  /// Datagrams dropped by the kernel since construction, by the filter or because the queue was
  /// full. Threads: any.
  [[nodiscard]] std::uint64_t dropped() const noexcept;
  /// @returns true if the kernel took the datagram; otherwise it is lost, as on the wire.
  bool Send(std::span<const std::byte> bytes, const Endpoint& to) noexcept TWIN_REALTIME;
  /// @returns true if a datagram is queued, including one reported earlier but not received.
  [[nodiscard]] bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME override;

 private:
  const MonotonicClock& clock_;
  FileDescriptor fd_;
  Endpoint local_;
};

/// Outcome of a receive or a send.
enum class StreamResult : std::uint8_t {
  kDone,     ///< some bytes moved
  kPending,  ///< none now
  kClosed,   ///< gracefully, by the peer (FIN)
  kReset,    ///< broken (RST, timeout)
};

/// A TCP connection that never blocks, except in Connect. TCP_NODELAY; keep-alive idle 1 s,
/// interval 1 s, 3 probes, as clients of the real robot set it.
/// Threads: one receives, one sends.
class TcpStream {
 public:
  explicit TcpStream(FileDescriptor fd);
  /// Blocks for at most `timeout`. @throws RobotFault, with the cure, if refused or unanswered.
  [[nodiscard]] static TcpStream Connect(const Endpoint& to, Duration timeout);

  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  [[nodiscard]] const Endpoint& local() const noexcept { return local_; }
  /// 0.0.0.0:0 if the peer had disconnected before the query.
  [[nodiscard]] const Endpoint& peer() const noexcept { return peer_; }
  /// @param room  if empty, nothing is received (kPending).
  [[nodiscard]] StreamResult Receive(std::span<std::byte> room, std::size_t& received) noexcept;
  [[nodiscard]] StreamResult Send(std::span<const std::byte> bytes, std::size_t& sent) noexcept;
  /// Closes gracefully (FIN): sent bytes arrive; unread bytes are dropped.
  void Close() noexcept;
  /// Resets the connection (RST).
  void ResetConnection() noexcept;

 private:
  FileDescriptor fd_;
  Endpoint local_;
  Endpoint peer_;
};

/// Accepts TCP connections. Threads: one.
class TcpListener {
 public:
  /// @throws EnvironmentError if the port is in use or the address is not this machine's.
  explicit TcpListener(const Endpoint& local);
  [[nodiscard]] Endpoint local() const;
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  /// @returns the next waiting connection; nullopt if none waits. @throws EnvironmentError if too
  /// many files are open; the connection keeps waiting.
  [[nodiscard]] std::optional<TcpStream> Accept();

 private:
  FileDescriptor fd_;
};

}  // namespace twin::fci

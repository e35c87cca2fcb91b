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
#include "twin/rt/arrival.h"

// IPv4 sockets, as far as the Franka Control Interface needs them: nothing here blocks unless it
// says so. Errors: EnvironmentError or InputError with address, reason and cure.
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

/// Whether the address is one of this machine's own, 127.0.0.0/8.
[[nodiscard]] constexpr bool IsLoopback(std::uint32_t address) noexcept {
  return address >> 24 == 127;
}

/// "127.0.0.1:1337".
[[nodiscard]] std::string ToString(const Endpoint& endpoint);
/// @param host  an IPv4 address or a name. May wait for the resolver. @throws InputError naming it.
[[nodiscard]] Endpoint Resolve(const std::string& host, std::uint16_t port);

/// A network: "192.168.1.0/24".
struct Network {
  std::uint32_t address = 0;
  std::uint32_t mask = 0;
  [[nodiscard]] bool Contains(std::uint32_t other) const noexcept {
    return (other & mask) == address;
  }
};
/// @throws InputError naming what is wrong with it.
[[nodiscard]] Network ParseNetwork(const std::string& text);

/// Waits at several descriptors until one of them is ready, or until `deadline`.
/// @param waited  as poll(2) takes them. @returns whether one is ready. Real-time: noexcept,
/// bounded by the deadline, allocates nothing.
[[nodiscard]] bool AwaitAny(std::span<pollfd> waited, const MonotonicClock& clock,
                            Time deadline) noexcept TWIN_REALTIME;

/// A datagram that was received.
struct Datagram {
  std::span<const std::byte> bytes;  ///< of the buffer given
  Endpoint from;
  /// When the kernel received it, on the clock given to the socket; never later than now, nor
  /// earlier than rt::kOldestStamp before. Now, when the kernel does not tell.
  Time at{};
};

/// A UDP socket that never blocks. Also an Arrival: what a thread waits at.
/// Threads: one receives, one sends (may be the same). Real-time: Receive, Send and AwaitUntil are
/// noexcept and allocate nothing.
class UdpSocket final : public rt::Arrival {
 public:
  /// Binds `local` (port 0: any free one). @throws EnvironmentError.
  UdpSocket(const MonotonicClock& clock, const Endpoint& local);

  [[nodiscard]] Endpoint local() const noexcept { return local_; }
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }

  /// The next datagram that waits; nothing when none does. Longer ones are cut to `buffer`.
  [[nodiscard]] std::optional<Datagram> Receive(std::span<std::byte> buffer) noexcept TWIN_REALTIME;
  /// From now on the kernel drops what comes from elsewhere, before it takes room in the socket or
  /// a wake-up of who waits: strangers' datagrams, however many, hold back nobody else's. What
  /// waits already is left; a kernel that knows no socket filters leaves all to who receives. More
  /// than once: the last counts. Port 0: nothing is let in. A system call.
  /// @note A filter and no connect(2), which would tie a socket of all this machine's addresses to
  /// one of them for good, and let a peer's ICMP errors fail sends.
  void ListenOnlyTo(const Endpoint& peer) noexcept TWIN_REALTIME;
  /// Datagrams that the kernel dropped since construction: by the filter, or because too many
  /// waited. Any thread.
  [[nodiscard]] std::uint64_t dropped() const noexcept;
  /// @returns whether the kernel took it; what it does not take is lost, as on the wire.
  bool Send(std::span<const std::byte> bytes, const Endpoint& to) noexcept TWIN_REALTIME;
  /// @returns whether a datagram waits; also one that an earlier call told of and that was left.
  [[nodiscard]] bool AwaitUntil(Time deadline) noexcept TWIN_REALTIME override;

 private:
  const MonotonicClock& clock_;
  FileDescriptor fd_;
  Endpoint local_;
};

/// How a receive or a send went.
enum class StreamResult : std::uint8_t {
  kDone,     ///< some bytes
  kPending,  ///< none now
  kClosed,   ///< by the peer, in order (FIN)
  kReset,    ///< broken (RST, timeout)
};

/// A TCP connection that never blocks (but for Connect); TCP_NODELAY, keep-alive idle 1 s, interval
/// 1 s, 3 probes, as clients of the real robot set it.
/// Threads: one receives, one sends.
class TcpStream {
 public:
  explicit TcpStream(FileDescriptor fd);
  /// Blocks for `timeout` at most. @throws RobotFault: refused, no answer, with the cure.
  [[nodiscard]] static TcpStream Connect(const Endpoint& to, Duration timeout);

  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  [[nodiscard]] const Endpoint& local() const noexcept { return local_; }
  /// 0.0.0.0:0 when it had gone before it could be asked.
  [[nodiscard]] const Endpoint& peer() const noexcept { return peer_; }
  /// @param room  with no room nothing is received (kPending).
  [[nodiscard]] StreamResult Receive(std::span<std::byte> room, std::size_t& received) noexcept;
  [[nodiscard]] StreamResult Send(std::span<const std::byte> bytes, std::size_t& sent) noexcept;
  /// Orderly end (FIN): what was sent arrives. Bytes that were not read are dropped.
  void Close() noexcept;
  /// Reset (RST).
  void ResetConnection() noexcept;

 private:
  FileDescriptor fd_;
  Endpoint local_;
  Endpoint peer_;
};

/// Accepts TCP connections. Threads: one.
class TcpListener {
 public:
  /// @throws EnvironmentError: the port is taken, the address is none of this machine's.
  explicit TcpListener(const Endpoint& local);
  [[nodiscard]] Endpoint local() const;
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  /// The next connection that waits; nothing when none does. @throws EnvironmentError: too many
  /// files are open; the connection goes on waiting.
  [[nodiscard]] std::optional<TcpStream> Accept();

 private:
  FileDescriptor fd_;
};

}  // namespace twin::fci

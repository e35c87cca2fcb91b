#include <linux/filter.h>
#include <linux/sock_diag.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <limits>

#include "fci/socket_address.h"
#include "twin/fci/sockets.h"
#include "twin/rt/host_time.h"

namespace twin::fci {
namespace {

/// Errors of earlier sends to skip in one receive. The kernel reports each once; the bound limits
/// what foreign ICMP messages cost a cycle.
constexpr int kMostErrors = 16;

/// Kernel receive time of the message; now, if the kernel gives none.
Time ArrivalOf(const MonotonicClock& clock, msghdr& message) noexcept {
  for (cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr; one = CMSG_NXTHDR(&message, one)) {
    if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(one), sizeof stamp);
    return rt::TimeOfKernelStamp(clock, stamp);
  }
  return clock.Now();
}

timespec Span(Duration span) noexcept {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(span);
  return {static_cast<std::time_t>(seconds.count()), static_cast<long>((span - seconds).count())};
}

}  // namespace

bool AwaitAny(std::span<pollfd> waited, const MonotonicClock& clock, Time deadline) noexcept {
  for (;;) {
    const Time now = clock.Now();
    const timespec left = Span(deadline > now ? deadline - now : Duration::zero());
    const int ready = ppoll(waited.data(), waited.size(), &left, nullptr);
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

UdpSocket::UdpSocket(const MonotonicClock& clock, const Endpoint& local)
    : clock_(clock), fd_(OpenSocket(SOCK_DGRAM)) {
  SetOption(fd_.get(), SOL_SOCKET, SO_TIMESTAMPNS, 1);
  Bind(fd_.get(), local);
  local_ = LocalEndpoint(fd_.get());
}

std::optional<Datagram> UdpSocket::Receive(std::span<std::byte> buffer) noexcept {
  sockaddr_in from{};
  iovec room{buffer.data(), buffer.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control;
  for (int tries = 0; tries < kMostErrors; ++tries) {
    msghdr message{};
    message.msg_name = &from;
    message.msg_namelen = sizeof from;
    message.msg_iov = &room;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const auto received = recvmsg(fd_.get(), &message, MSG_DONTWAIT);
    if (received >= 0) {
      return Datagram{buffer.first(static_cast<std::size_t>(received)), EndpointOf(from),
                      ArrivalOf(clock_, message)};
    }
    if (errno == EAGAIN) break;
  }
  return {};
}

void UdpSocket::ListenOnlyTo(const Endpoint& peer) noexcept {
  // Offset 0 of the data is the UDP header, which begins with the source port. The IP header, with
  // the source address at 12, has an offset base of its own.
  constexpr std::uint32_t kSourceAddress = static_cast<std::uint32_t>(SKF_NET_OFF) + 12;
  constexpr std::uint32_t kSourcePort = 0;
  constexpr std::uint32_t kWhole = std::numeric_limits<std::uint32_t>::max();
  std::array<sock_filter, 6> steps{{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kSourceAddress),
                                    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, peer.address, 0, 3),
                                    BPF_STMT(BPF_LD | BPF_H | BPF_ABS, kSourcePort),
                                    BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, peer.port, 0, 1),
                                    BPF_STMT(BPF_RET | BPF_K, kWhole),
                                    BPF_STMT(BPF_RET | BPF_K, 0)}};
  const sock_fprog filter{steps.size(), steps.data()};
  static_cast<void>(setsockopt(fd_.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter));
}

std::uint64_t UdpSocket::dropped() const noexcept {
  std::array<std::uint32_t, SK_MEMINFO_VARS> figures{};
  socklen_t size = sizeof figures;
  static_cast<void>(getsockopt(fd_.get(), SOL_SOCKET, SO_MEMINFO, figures.data(), &size));
  return figures[SK_MEMINFO_DROPS];
}

bool UdpSocket::Send(std::span<const std::byte> bytes, const Endpoint& to) noexcept {
  const sockaddr_in address = AddressOf(to);
  const auto sent = sendto(fd_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                           reinterpret_cast<const sockaddr*>(&address), sizeof address);
  return sent == static_cast<ssize_t>(bytes.size());
}

bool UdpSocket::AwaitUntil(Time deadline) noexcept {
  pollfd waiting{fd_.get(), POLLIN, 0};
  return AwaitAny({&waiting, 1}, clock_, deadline);
}

}  // namespace twin::fci

#pragma once

#include <cstdint>

namespace twin::proxy {

/// Statistics of one direction's datagrams. Each received datagram was relayed once, twice
/// (duplicated), or not at all (lost, dropped, or pending when its session ended).
struct DirectionCounts {
  std::uint64_t came = 0;        ///< received from the robot or the client; numbered from 0
  std::uint64_t relayed = 0;     ///< copies sent
  std::uint64_t delayed = 0;     ///< held for a time above 0
  std::uint64_t lost = 0;        ///< by the faults, or because too many were pending
  std::uint64_t duplicated = 0;  ///< relayed twice
  std::uint64_t reordered = 0;   ///< copies sent after a datagram that was received later
  std::uint64_t dropped = 0;     ///< longer than any protocol datagram, or not taken by the system
  /// From other sources, ignored and not numbered. Counts only those that the kernel let in: it
  /// drops them once both endpoints are known (fci::UdpSocket::ListenOnlyTo).
  std::uint64_t foreign = 0;
  bool operator==(const DirectionCounts&) const = default;
};

/// Statistics of both directions.
struct RelayCounts {
  DirectionCounts state;    ///< robot to client
  DirectionCounts command;  ///< client to robot
  bool operator==(const RelayCounts&) const = default;
};

/// Sums the counts of sessions.
RelayCounts& operator+=(RelayCounts& sum, const RelayCounts& one) noexcept;

}  // namespace twin::proxy

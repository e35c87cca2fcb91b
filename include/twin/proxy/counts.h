#pragma once

#include <cstdint>

namespace twin::proxy {

/// What became of the datagrams of one direction. A datagram that came was relayed once, twice
/// (duplicated), or not at all (lost, dropped, or still on its way when its session ended).
struct DirectionCounts {
  std::uint64_t came = 0;        ///< of the robot, or of the client; each has a number, from 0
  std::uint64_t relayed = 0;     ///< copies that went on
  std::uint64_t delayed = 0;     ///< held for a time above 0
  std::uint64_t lost = 0;        ///< by the faults, or because too many were on the way
  std::uint64_t duplicated = 0;  ///< of which a second copy was made
  std::uint64_t reordered = 0;   ///< copies that went on behind a datagram that had come later
  std::uint64_t dropped = 0;     ///< longer than any of the protocol, or not taken by the system
  /// Of somebody else, who is not listened to, as far as the kernel let them in: once both
  /// endpoints are known it drops them (fci::UdpSocket::ListenOnlyTo). These have no number.
  std::uint64_t foreign = 0;
  bool operator==(const DirectionCounts&) const = default;
};

/// Both directions.
struct RelayCounts {
  DirectionCounts state;    ///< robot to client
  DirectionCounts command;  ///< client to robot
  bool operator==(const RelayCounts&) const = default;
};

/// Adds the sessions' counts up.
RelayCounts& operator+=(RelayCounts& sum, const RelayCounts& one) noexcept;

}  // namespace twin::proxy

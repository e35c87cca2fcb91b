#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "twin/core/time.h"

namespace twin::record {

/// Transport protocol of a packet.
enum class Transport : std::uint8_t { kTcp, kUdp };

/// An endpoint: IPv4 address, in host byte order, and port.
struct PacketEnd {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  auto operator<=>(const PacketEnd&) const = default;
};

/// A datagram, or a piece of a TCP stream, without headers.
struct Packet {
  Time at{};  ///< on the run's clock
  Transport transport = Transport::kUdp;
  PacketEnd from;
  PacketEnd to;
  std::span<const std::byte> bytes;
};

}  // namespace twin::record

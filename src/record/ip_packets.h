#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "twin/record/packet.h"

namespace twin::record {

/// Takes datagrams and TCP bytes out of IPv4 packets that nobody vouches for: puts fragments
/// together, leaves repeated TCP bytes out. Anything else is no packet for it.
///
/// What it keeps is bounded: the fragments of the last kUnfinished datagrams, one sequence number
/// for each of the last kStreams directions.
class IpPackets {
 public:
  /// @param ip  from the first byte of IPv4's head. @returns the packet; its bytes are those of
  /// `ip`, or kept here until the next call. Nothing: unfinished, repeated, empty, or none of ours.
  [[nodiscard]] std::optional<Packet> Take(Time at, std::span<const std::byte> ip);

  /// Packets that were not UDP or TCP over IPv4, or damaged.
  [[nodiscard]] std::uint64_t passed_over() const noexcept { return passed_over_; }

 private:
  static constexpr std::size_t kUnfinished = 16;
  static constexpr std::size_t kStreams = 256;

  struct Unfinished {
    std::uint64_t key = 0;
    std::uint64_t other_key = 0;
    std::vector<std::byte> bytes;
    std::size_t received = 0;
    std::optional<std::size_t> total;
  };

  [[nodiscard]] std::optional<std::span<const std::byte>> Assemble(std::span<const std::byte> ip,
                                                                   std::span<const std::byte> body);
  [[nodiscard]] std::optional<Packet> TakeDatagram(Packet packet, std::span<const std::byte> body);
  [[nodiscard]] std::optional<Packet> TakeSegment(Packet packet, std::span<const std::byte> body);

  std::vector<Unfinished> unfinished_;
  std::vector<std::byte> assembled_;
  std::map<std::pair<PacketEnd, PacketEnd>, std::uint32_t> next_sequence_;
  std::uint64_t passed_over_ = 0;
};

}  // namespace twin::record

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

/// Extracts datagrams and TCP bytes from untrusted IPv4 packets: reassembles fragments, skips
/// repeated TCP bytes and all other packets.
///
/// Memory is bounded: the fragments of the last kUnfinished datagrams, and one sequence number for
/// each of the last kStreams directions.
class IpPackets {
 public:
  /// @param ip  starts with the IPv4 header. @returns the packet, with its bytes in `ip` or kept
  /// here until the next call; nullopt if it is incomplete, repeated, empty or of another kind.
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

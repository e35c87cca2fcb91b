#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "twin/core/realtime.h"
#include "twin/proxy/counts.h"
#include "twin/robot/channel.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/message_fate.h"

namespace twin::proxy {

/// The longest datagram that is relayed, bytes: above any of the protocol.
inline constexpr std::size_t kLongestPacket = 4096;

/// A datagram on its way.
struct Packet {
  std::uint64_t message_id = 0;  ///< its number in its direction
  std::size_t size = 0;          ///< of bytes
  std::array<std::byte, kLongestPacket> bytes;
};

/// Where a direction's datagrams go on to.
class Output {
 public:
  virtual ~Output() = default;
  /// @returns whether the system took it.
  virtual bool Send(std::span<const std::byte> bytes) noexcept TWIN_REALTIME = 0;
};

/// One direction of a session's datagrams: each gets the next number, with it a fate, and goes on
/// when the event queue says so.
///
/// Threads: that of the event queue. Real-time: allocates nothing after construction.
class RelayDirection final : private rt::EventHandler {
 public:
  /// @param events  on whose time they go on; with room for twice Channel's capacity.
  /// @param exit    both must outlive the direction.
  RelayDirection(const rt::DirectionConfig& config, std::uint64_t seed,
                 const rt::FateStreams& streams, rt::EventQueue& events, rt::EventOrder order,
                 Output& exit);

  /// A datagram came, at the queue's present. @param bytes  more than kLongestPacket: dropped.
  void Take(std::span<const std::byte> bytes) noexcept TWIN_REALTIME;
  /// One came that is nobody's who is listened to.
  void CountForeign() noexcept { ++counts_.foreign; }

  [[nodiscard]] const DirectionCounts& counts() const noexcept { return counts_; }

  /// Of one direction at the same time: two copies of each datagram.
  static constexpr std::size_t kMostEvents = 2 * robot::Channel<Packet>::kCapacity;

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;

  robot::Channel<Packet> channel_;
  Output& exit_;
  Packet incoming_{};  ///< whose message_id is the next number
  std::uint64_t newest_gone_ = 0;
  DirectionCounts counts_;
};

}  // namespace twin::proxy

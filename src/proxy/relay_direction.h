#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "twin/core/realtime.h"
#include "twin/faults/message_fate.h"
#include "twin/proxy/counts.h"
#include "twin/robot/channel.h"
#include "twin/rt/event_queue.h"

namespace twin::proxy {

/// Longest relayed datagram, bytes: above the protocol's longest.
inline constexpr std::size_t kLongestPacket = 4096;

/// A pending datagram.
struct Packet {
  std::uint64_t message_id = 0;  ///< number in its direction
  std::size_t size = 0;          ///< bytes
  std::array<std::byte, kLongestPacket> bytes;
};

/// Destination of a direction's datagrams.
class Output {
 public:
  virtual ~Output() = default;
  /// @returns true if the system took the datagram.
  virtual bool Send(std::span<const std::byte> bytes) noexcept TWIN_REALTIME = 0;
};

/// One direction of a session's datagrams: assigns each the next number and the number's fate, and
/// sends it when the event queue fires.
///
/// Threads: the event queue's. Real-time: does not allocate after construction.
class RelayDirection final : private rt::EventHandler {
 public:
  /// @param events  times the sending; needs room for twice Channel's capacity.
  /// @param exit    destination; both must outlive the direction.
  RelayDirection(const faults::DirectionConfig& config, std::uint64_t seed,
                 const faults::FateStreams& streams, rt::EventQueue& events, rt::EventOrder order,
                 Output& exit);

  /// Takes a datagram at the queue's current time. @param bytes  dropped if longer than
  /// kLongestPacket.
  void Take(std::span<const std::byte> bytes) noexcept TWIN_REALTIME;
  /// Counts a datagram from an unknown source.
  void CountForeign() noexcept { ++counts_.foreign; }

  [[nodiscard]] const DirectionCounts& counts() const noexcept { return counts_; }

  /// Upper bound of pending events in one direction: two copies of each datagram.
  static constexpr std::size_t kMostEvents = 2 * robot::Channel<Packet>::kCapacity;

 private:
  void OnEvent(Time now, std::uint64_t token) noexcept override;

  robot::Channel<Packet> channel_;
  Output& exit_;
  Packet incoming_{};  ///< its message_id is the next number
  std::uint64_t newest_gone_ = 0;
  DirectionCounts counts_;
};

}  // namespace twin::proxy

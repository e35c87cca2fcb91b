#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace twin::ros2 {

/// How much of a datagram DDS may read: that of whole, known submessages whose numbers are sound; 0
/// of what is no RTPS. Anybody who reaches a port can send the others, and Fast DDS 2.9.1 ends the
/// process by an assertion (its statistics submessage of a wrong length) or is busy for ever (a
/// heartbeat of 2^40 samples).
///
/// Threads: any. Real-time: noexcept, allocates nothing.
/// Source: OMG DDSI-RTPS 2.3, 8.3.3 and 9.4.5.
[[nodiscard]] std::size_t ReadableBytes(std::span<const std::byte> datagram) noexcept;

}  // namespace twin::ros2

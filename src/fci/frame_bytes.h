#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fci/wire.h"
#include "twin/fci/frame_reader.h"
#include "twin/fci/protocol.h"
#include "twin/fci/requests.h"

// Heads of TCP frames, and assembly of frames from head and payload. Source: FCI protocol 5,
// framing.
namespace twin::fci {

[[nodiscard]] constexpr std::size_t HeadBytes(HeadKind kind) noexcept {
  return kind == HeadKind::kArm ? kArmHeadBytes : kHandHeadBytes;
}

/// @param bytes  at least a head's.
[[nodiscard]] FrameHead ReadHead(HeadKind kind, std::span<const std::byte> bytes) noexcept;

/// A frame under construction: its head is written, its payload is allocated.
class NewFrame {
 public:
  /// Of the arm. @param number  of the request in the protocol.
  NewFrame(std::uint32_t number, std::uint32_t command_id, std::size_t payload_bytes);
  NewFrame(HandCommandId command, std::uint32_t command_id, std::size_t payload_bytes);
  NewFrame(VacuumCommandId command, std::uint32_t command_id, std::size_t payload_bytes);

  [[nodiscard]] std::byte* payload() noexcept { return bytes_.data() + head_bytes_; }
  [[nodiscard]] std::vector<std::byte> Release() && noexcept { return std::move(bytes_); }

 private:
  std::size_t head_bytes_;
  std::vector<std::byte> bytes_;
};

}  // namespace twin::fci

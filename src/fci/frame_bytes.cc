#include "fci/frame_bytes.h"

#include <algorithm>
#include <utility>

namespace twin::fci {

FrameHead ReadHead(HeadKind kind, std::span<const std::byte> bytes) noexcept {
  FrameHead head;
  if (kind == HeadKind::kArm) {
    wire::Take(bytes.data(), head.command);
    wire::Take(bytes.data() + 4, head.command_id);
    wire::Take(bytes.data() + 8, head.size);
  } else {
    std::uint16_t command = 0;
    wire::Take(bytes.data(), command);
    head.command = command;
    wire::Take(bytes.data() + 2, head.command_id);
    wire::Take(bytes.data() + 6, head.size);
  }
  return head;
}

NewFrame::NewFrame(std::uint32_t number, std::uint32_t command_id, std::size_t payload_bytes)
    : head_bytes_(kArmHeadBytes), bytes_(kArmHeadBytes + payload_bytes) {
  wire::Put(bytes_.data(), number);
  wire::Put(bytes_.data() + 4, command_id);
  wire::Put(bytes_.data() + 8, static_cast<std::uint32_t>(bytes_.size()));
}

NewFrame::NewFrame(HandCommandId command, std::uint32_t command_id, std::size_t payload_bytes)
    : head_bytes_(kHandHeadBytes), bytes_(kHandHeadBytes + payload_bytes) {
  wire::Put(bytes_.data(), static_cast<std::uint16_t>(command));
  wire::Put(bytes_.data() + 2, command_id);
  wire::Put(bytes_.data() + 6, static_cast<std::uint32_t>(bytes_.size()));
}

NewFrame::NewFrame(VacuumCommandId command, std::uint32_t command_id, std::size_t payload_bytes)
    : NewFrame(static_cast<HandCommandId>(command), command_id, payload_bytes) {}

std::vector<std::byte> BytesOf(HeadKind kind, const Frame& frame) {
  const FrameHead& head = frame.head;
  NewFrame whole = kind == HeadKind::kArm
                       ? NewFrame(head.command, head.command_id, frame.payload.size())
                       : NewFrame(static_cast<HandCommandId>(head.command), head.command_id,
                                  frame.payload.size());
  std::ranges::copy(frame.payload, whole.payload());
  return std::move(whole).Release();
}

}  // namespace twin::fci

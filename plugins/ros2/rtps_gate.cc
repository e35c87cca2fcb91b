#include "plugins/ros2/rtps_gate.h"

#include <cstring>

#include "plugins/ros2/cdr.h"

namespace twin::ros2 {
namespace {

constexpr std::size_t kHeaderBytes = 20;
constexpr std::size_t kSubmessageHeaderBytes = 4;

/// Submessages of the standard by their ids, with the fewest bytes that each has; 0: none such.
std::size_t LeastBytesOf(std::uint8_t id) noexcept {
  switch (id) {
    case 0x01:             // PAD, of any length
    case 0x09: return 1;   // INFO_TS, of 8 or none
    case 0x0f: return 4;   // INFO_REPLY
    case 0x0d: return 8;   // INFO_REPLY_IP4
    case 0x0e: return 12;  // INFO_DST
    case 0x0c:             // INFO_SRC
    case 0x15: return 20;  // DATA
    case 0x06:             // ACKNACK
    case 0x12:             // NACK_FRAG
    case 0x13: return 24;  // HEARTBEAT_FRAG
    case 0x07:             // HEARTBEAT
    case 0x08: return 28;  // GAP
    case 0x16: return 32;  // DATA_FRAG
    default: return 0;
  }
}

bool MayBeEmpty(std::uint8_t id) noexcept {
  return id == 0x01 || id == 0x09;
}

/// The body of one submessage.
struct Body {
  std::span<const std::byte> bytes;
  bool is_little;

  [[nodiscard]] std::uint32_t Word(std::size_t at) const noexcept {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof(word));
    return is_little ? word : __builtin_bswap32(word);
  }
  /// A sequence number below 2^32, which takes 50 days at 1 kHz: Fast DDS steps through all that
  /// were skipped, with its locks held.
  [[nodiscard]] bool IsNumber(std::size_t at) const noexcept { return Word(at) == 0; }
};

/// Whether the numbers of a submessage, of LeastBytesOf() at least, cost no more than they should.
bool IsAffordable(std::uint8_t id, const Body& body) noexcept {
  constexpr std::uint32_t kMostBits = 256;  // of a set
  switch (id) {
    case 0x06: return body.IsNumber(8) && body.Word(16) <= kMostBits;
    case 0x07: return body.IsNumber(8) && body.IsNumber(16);
    case 0x08: return body.IsNumber(8) && body.IsNumber(16) && body.Word(24) <= kMostBits;
    case 0x12:
    case 0x13: return body.IsNumber(8);
    case 0x15: return body.IsNumber(12);
    case 0x16: return body.IsNumber(12) && body.Word(28) <= kMostMessageBytes;
    default: return true;
  }
}

}  // namespace

std::size_t ReadableBytes(std::span<const std::byte> datagram) noexcept {
  if (datagram.size() < kHeaderBytes || std::memcmp(datagram.data(), "RTPS", 4) != 0) return 0;
  std::size_t at = kHeaderBytes;
  while (datagram.size() - at >= kSubmessageHeaderBytes) {
    const auto id = static_cast<std::uint8_t>(datagram[at]);
    const bool is_little = (datagram[at + 1] & std::byte{1}) != std::byte{0};
    const auto low = static_cast<std::size_t>(datagram[at + (is_little ? 2 : 3)]);
    const auto high = static_cast<std::size_t>(datagram[at + (is_little ? 3 : 2)]);
    const std::size_t rest = datagram.size() - at - kSubmessageHeaderBytes;
    std::size_t length = low | high << 8;
    if (length == 0 && !MayBeEmpty(id)) length = rest;  // the last one may go to the end
    const bool is_known = LeastBytesOf(id) != 0;
    const bool is_whole = length <= rest && (length >= LeastBytesOf(id) || MayBeEmpty(id));
    if (!is_known || !is_whole) break;
    if (!IsAffordable(id, {datagram.subspan(at + kSubmessageHeaderBytes, length), is_little}))
      break;
    at += kSubmessageHeaderBytes + length;
  }
  return at == kHeaderBytes ? 0 : at;
}

}  // namespace twin::ros2

#include "record/ip_packets.h"

#include <algorithm>

#include "record/pcapng_format.h"

namespace twin::record {
namespace {

/// The largest IPv4 packet.
constexpr std::size_t kLargest = 65535;

std::uint32_t Big(std::span<const std::byte> bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = (value << 8) | std::to_integer<std::uint32_t>(bytes[at + i]);
  }
  return value;
}

std::uint16_t Big16(std::span<const std::byte> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(Big(bytes, at, 2));
}

}  // namespace

std::optional<Packet> IpPackets::Take(Time at, std::span<const std::byte> ip) {
  const auto pass_over = [this]() -> std::optional<Packet> {
    ++passed_over_;
    return std::nullopt;
  };
  if (ip.size() < pcapng::kIpBytes || Big(ip, 0, 1) >> 4 != 4) return pass_over();
  const std::size_t head = (Big(ip, 0, 1) & 0xf) * 4;
  const std::size_t length = Big16(ip, 2);
  const std::uint32_t protocol = Big(ip, 9, 1);
  if (head < pcapng::kIpBytes || length < head || length > ip.size()) return pass_over();
  if (protocol != pcapng::kTcp && protocol != pcapng::kUdp) return pass_over();

  std::span<const std::byte> body = ip.subspan(head, length - head);
  const bool is_fragment = (Big16(ip, 6) & 0x3fff) != 0;
  if (is_fragment) {
    const auto whole = Assemble(ip, body);
    if (!whole) return std::nullopt;
    body = *whole;
  }
  const bool tcp = protocol == pcapng::kTcp;
  if (body.size() < (tcp ? pcapng::kTcpBytes : pcapng::kUdpBytes)) return pass_over();
  const Packet packet{.at = at,
                      .transport = tcp ? Transport::kTcp : Transport::kUdp,
                      .from = {Big(ip, 12, 4), Big16(body, 0)},
                      .to = {Big(ip, 16, 4), Big16(body, 2)},
                      .bytes = {}};
  return tcp ? TakeSegment(packet, body) : TakeDatagram(packet, body);
}

std::optional<std::span<const std::byte>> IpPackets::Assemble(std::span<const std::byte> ip,
                                                              std::span<const std::byte> body) {
  // Source and destination; identification and protocol: RFC 791.
  const std::uint64_t key = (std::uint64_t{Big(ip, 12, 4)} << 32) | Big(ip, 16, 4);
  const std::uint64_t other_key = (std::uint64_t{Big16(ip, 4)} << 8) | Big(ip, 9, 1);
  const std::uint16_t flags = Big16(ip, 6);
  const std::size_t begin = std::size_t{flags & 0x1fffU} * 8;
  const bool more_follow = (flags & 0x2000) != 0;
  if (begin + body.size() > kLargest) {
    ++passed_over_;
    return std::nullopt;
  }
  auto it = std::ranges::find_if(unfinished_, [&](const Unfinished& candidate) {
    return candidate.key == key && candidate.other_key == other_key;
  });
  if (it == unfinished_.end()) {
    if (unfinished_.size() == kUnfinished) {
      unfinished_.erase(unfinished_.begin());
      ++passed_over_;
    }
    unfinished_.push_back(
        {.key = key, .other_key = other_key, .bytes = {}, .received = 0, .total = {}});
    it = unfinished_.end() - 1;
  }
  it->bytes.resize(std::max(it->bytes.size(), begin + body.size()));
  std::ranges::copy(body, it->bytes.begin() + static_cast<std::ptrdiff_t>(begin));
  it->received += body.size();
  if (!more_follow) it->total = begin + body.size();
  if (!it->total || it->received < *it->total) return std::nullopt;
  assembled_ = std::move(it->bytes);
  assembled_.resize(*it->total);
  unfinished_.erase(it);
  return assembled_;
}

std::optional<Packet> IpPackets::TakeDatagram(Packet packet, std::span<const std::byte> body) {
  const std::size_t length = Big16(body, 4);
  if (length < pcapng::kUdpBytes || length > body.size()) {
    ++passed_over_;
    return std::nullopt;
  }
  packet.bytes = body.subspan(pcapng::kUdpBytes, length - pcapng::kUdpBytes);
  return packet;
}

std::optional<Packet> IpPackets::TakeSegment(Packet packet, std::span<const std::byte> body) {
  constexpr std::uint32_t kSyn = 0x02;
  const std::size_t head = (Big(body, 12, 1) >> 4) * 4;
  if (head < pcapng::kTcpBytes || head > body.size()) {
    ++passed_over_;
    return std::nullopt;
  }
  const std::uint32_t sequence = Big(body, 4, 4);
  if (next_sequence_.size() == kStreams) next_sequence_.clear();
  auto [next, is_new] = next_sequence_.try_emplace({packet.from, packet.to}, sequence);
  if ((Big(body, 13, 1) & kSyn) != 0) {
    next->second = sequence + 1;
    return std::nullopt;
  }
  packet.bytes = body.subspan(head);
  // Sequence numbers wrap: their difference tells which is later (RFC 9293).
  const auto repeated = static_cast<std::int32_t>(next->second - sequence);
  if (repeated > 0) {
    packet.bytes =
        packet.bytes.subspan(std::min(packet.bytes.size(), static_cast<std::size_t>(repeated)));
  }
  if (packet.bytes.empty()) return std::nullopt;
  next->second = sequence + static_cast<std::uint32_t>(body.size() - head);
  return packet;
}

}  // namespace twin::record

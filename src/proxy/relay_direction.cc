#include "proxy/relay_direction.h"

#include <algorithm>

namespace twin::proxy {
namespace {

void Add(DirectionCounts& sum, const DirectionCounts& one) noexcept {
  sum.came += one.came;
  sum.relayed += one.relayed;
  sum.delayed += one.delayed;
  sum.lost += one.lost;
  sum.duplicated += one.duplicated;
  sum.reordered += one.reordered;
  sum.dropped += one.dropped;
  sum.foreign += one.foreign;
}

}  // namespace

RelayCounts& operator+=(RelayCounts& sum, const RelayCounts& one) noexcept {
  Add(sum.state, one.state);
  Add(sum.command, one.command);
  return sum;
}

RelayDirection::RelayDirection(const faults::DirectionConfig& config, std::uint64_t seed,
                               const faults::FateStreams& streams, rt::EventQueue& events,
                               rt::EventOrder order, Output& exit)
    : channel_(config, seed, streams, events, order), exit_(exit) {}

void RelayDirection::Take(std::span<const std::byte> bytes) noexcept {
  ++counts_.came;
  if (bytes.size() > incoming_.bytes.size()) {
    ++counts_.dropped;
  } else {
    std::ranges::copy(bytes, incoming_.bytes.begin());
    incoming_.size = bytes.size();
    const faults::Fate fate = channel_.Send(incoming_, *this);
    counts_.lost += fate.lost ? 1 : 0;
    counts_.delayed += fate.delay > Duration::zero() ? 1 : 0;
    counts_.duplicated += fate.duplicated ? 1 : 0;
  }
  ++incoming_.message_id;
}

void RelayDirection::OnEvent(Time /*now*/, std::uint64_t token) noexcept {
  const Packet& packet = channel_.Receive(token);
  if (!exit_.Send(std::span(packet.bytes).first(packet.size))) {
    ++counts_.dropped;
    return;
  }
  ++counts_.relayed;
  if (packet.message_id < newest_gone_) ++counts_.reordered;
  newest_gone_ = std::max(newest_gone_, packet.message_id);
}

}  // namespace twin::proxy

#include "twin/fci/capture.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "twin/rt/host_time.h"

namespace twin::fci {
namespace {

/// The writer's pause when it has nothing to write.
constexpr std::chrono::microseconds kIdlePause(1000);

}  // namespace

Capture::Capture(const std::filesystem::path& path)
    : writer_(path), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

Capture::~Capture() {
  StopThread();
}

void Capture::PutRealtime(const record::Packet& packet) noexcept {
  const bool put = datagrams_.TryPushWith([&packet](Datagram& slot) {
    const std::size_t size = std::min(packet.bytes.size(), slot.bytes.size());
    std::copy_n(packet.bytes.begin(), size, slot.bytes.begin());
    slot.packet = packet;
    slot.packet.bytes = std::span<const std::byte>(slot.bytes).first(size);
  });
  if (!put) dropped_.fetch_add(1, std::memory_order_relaxed);
}

void Capture::Put(const record::Packet& packet) {
  Kept kept{packet, {packet.bytes.begin(), packet.bytes.end()}};
  const std::scoped_lock lock(others_lock_);
  others_.push_back(std::move(kept));
}

void Capture::Run(const std::stop_token& stop) {
  while (true) {
    // Read before Drain(), so that packets put before the stop request are still written.
    const bool last = stop.stop_requested();
    if (Drain()) continue;
    if (last) return;
    rt::Pause(kIdlePause);
  }
}

bool Capture::Drain() {
  waiting_.clear();
  {
    const std::scoped_lock lock(others_lock_);
    waiting_.swap(others_);
  }
  // Drain the ring after the list: then it includes all datagrams older than the list's packets.
  const auto keep = [this](const Datagram& slot) {
    waiting_.push_back({slot.packet, {slot.packet.bytes.begin(), slot.packet.bytes.end()}});
  };
  for (std::size_t i = 0; i < kRing && datagrams_.TryPopWith(keep); ++i) {
  }
  std::ranges::stable_sort(waiting_, {}, [](const Kept& kept) { return kept.packet.at; });
  for (Kept& kept : waiting_) {
    if (failure_.happened()) break;
    kept.packet.bytes = kept.bytes;
    try {
      writer_.Add(kept.packet);
    } catch (...) {
      failure_.Keep();
    }
  }
  return !waiting_.empty();
}

void Capture::StopThread() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

std::uint64_t Capture::Finish() {
  StopThread();
  failure_.Rethrow();
  writer_.Finish();
  return dropped_.load(std::memory_order_relaxed);
}

}  // namespace twin::fci

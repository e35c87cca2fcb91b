#include "campaign/hang_watch.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace twin::campaign {

HangWatch::HangWatch(Duration patience, std::function<void(std::uint64_t)> give_up)
    : patience_(patience), give_up_(std::move(give_up)) {
  if (patience_ > Duration::zero()) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
}

HangWatch::World::World(HangWatch& watch, std::uint64_t seed) : watch_(watch), seed_(seed) {
  const std::scoped_lock lock(watch_.mutex_);
  watch_.begun_.emplace(seed_, watch_.clock_.Now());
}

HangWatch::World::~World() {
  const std::scoped_lock lock(watch_.mutex_);
  watch_.begun_.erase(seed_);
}

void HangWatch::Run(const std::stop_token& stop) {
  const Duration often = std::min<Duration>(patience_, std::chrono::seconds(1));
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    stopped_.wait_for(lock, stop, often, [] { return false; });
    const auto late = std::ranges::find_if(
        begun_, [&](const auto& world) { return clock_.Now() - world.second > patience_; });
    if (late != begun_.end()) {
      give_up_(late->first);
      begun_.erase(late);
    }
  }
}

}  // namespace twin::campaign

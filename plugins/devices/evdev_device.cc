#include "plugins/devices/evdev_device.h"

#include <poll.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/fci/sockets.h"
#include "twin/rt/host_time.h"

namespace twin::devices {
namespace {

/// Shortest interval, and smallest strength and change, of rumble commands.
constexpr Duration kBetweenRumbles = std::chrono::milliseconds(50);
constexpr double kLeastRumble = 0.05;
/// Rumble is renewed after this; the kernel ends it after one second (EventSource::Rumble).
constexpr Duration kRumbleLasts = std::chrono::milliseconds(900);

}  // namespace

EvdevDevice::EvdevDevice(const MonotonicClock& clock, std::unique_ptr<EventSource> source,
                         Open again, EvdevSettings settings)
    : clock_(clock),
      again_(std::move(again)),
      settings_(std::move(settings)),
      name_(source->capabilities().name),
      source_(std::move(source)),
      sampler_(source_->capabilities(), settings_.profile),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

std::optional<teleop::OperatorSample> EvdevDevice::Read(Time /*now*/) noexcept {
  if (!samples_.Refresh()) return {};
  return samples_.value();
}

void EvdevDevice::Feel(const teleop::OperatorFeedback& feedback) noexcept {
  felt_.Publish(feedback);
}

std::string EvdevDevice::Describe() const {
  return fmt::format("{} at {}", name_, settings_.where);
}

void EvdevDevice::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (source_) {
      Follow(stop);
      continue;
    }
    rt::Pause(kRetry);
    Seek();
  }
  if (source_ && rumble_ > 0) source_->Rumble(0);
}

void EvdevDevice::Follow(const std::stop_token& stop) {
  Time due = clock_.Now();
  while (!stop.stop_requested()) {
    pollfd waited{source_->fd(), POLLIN, 0};
    static_cast<void>(fci::AwaitAny({&waited, 1}, clock_, due));
    const EventSource::Result last = TakeWaiting();
    if (last == EventSource::Result::kGone) {
      lost_.store(true, std::memory_order_release);
      sampler_.LetGo();
      source_.reset();
      return;
    }
    const Time now = clock_.Now();
    if (now >= due) {
      Publish(now);
      due = now + kPeriod;
    }
    Rumble(now);
  }
}

EventSource::Result EvdevDevice::TakeWaiting() {
  input_event event{};
  for (;;) {
    const EventSource::Result result = source_->Next(event);
    if (result != EventSource::Result::kEvent) return result;
    const Time now = clock_.Now();
    if (sampler_.Take(event, now)) Publish(now);
  }
}

void EvdevDevice::Publish(Time now) {
  static_cast<void>(felt_.Refresh());
  samples_.Publish(sampler_.Sample(now, felt_.value().stopped));
}

void EvdevDevice::Rumble(Time now) {
  if (settings_.full_rumble <= 0 || now - rumbled_ < kBetweenRumbles) return;
  const Vector6& wrench = felt_.value().wrench;
  const double force = std::hypot(wrench[0], wrench[1], wrench[2]);
  const double full = std::min(force / settings_.full_rumble, 1.0);
  const double strength = full < kLeastRumble ? 0 : full;
  const bool is_over = strength > 0 && now - rumbled_ >= kRumbleLasts;
  if (std::abs(strength - rumble_) < kLeastRumble && !is_over) return;
  source_->Rumble(strength);
  rumble_ = strength;
  rumbled_ = now;
}

void EvdevDevice::Seek() {
  try {
    std::unique_ptr<EventSource> found = again_();
    if (found->capabilities().name != name_) return;  // another device at its path
    source_ = std::move(found);
  } catch (const Error&) {
    return;  // still unplugged
  }
  rumble_ = 0;
  lost_.store(false, std::memory_order_release);
}

}  // namespace twin::devices

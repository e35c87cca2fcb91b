#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "plugins/devices/evdev_sampler.h"
#include "plugins/devices/event_source.h"
#include "twin/core/clock.h"
#include "twin/rt/latest_value.h"
#include "twin/teleop/device.h"
#include "twin/teleop/device_registry.h"

namespace twin::devices {

struct EvdevSettings {
  EvdevProfile profile{};   ///< meaning of its axes and keys
  std::string where{};      ///< for users: "/dev/input/event5"
  double full_rumble = 10;  ///< force at the handle for full rumble, N; 0: no rumble
};

/// A SpaceMouse or a gamepad as a Linux input device.
///
///     events --> own thread --LatestValue--> Read()
///     rumble <-- own thread <--LatestValue-- Feel()
///
/// Gives a sample with every report of the device, and every kPeriod without one, as long as it is
/// plugged in. When unplugged it is lost, and reopened every kRetry. Samples then continue, with
/// all inputs released and no additional presses.
///
/// Threads: Read() and Feel() from one; lost() and Describe() from any. Real-time: Read() and
/// Feel() only exchange values with the thread.
class EvdevDevice final : public teleop::Device {
 public:
  static constexpr Duration kPeriod = std::chrono::milliseconds(10);
  static constexpr Duration kRetry = std::chrono::milliseconds(500);

  /// Reopens the device. @throws twin::Error if it is missing.
  using Open = std::function<std::unique_ptr<EventSource>()>;

  /// @param clock  must outlive this object. @param again  called on the device's thread.
  EvdevDevice(const MonotonicClock& clock, std::unique_ptr<EventSource> source, Open again,
              EvdevSettings settings);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override;
  [[nodiscard]] bool lost() const noexcept override {
    return lost_.load(std::memory_order_acquire);  // pairs with the release after the last sample
  }
  [[nodiscard]] std::string Describe() const override;

 private:
  void Run(const std::stop_token& stop);
  /// Reads and publishes until the device is unplugged, or `stop`.
  void Follow(const std::stop_token& stop);
  [[nodiscard]] EventSource::Result TakeWaiting();
  void Publish(Time now);
  void Rumble(Time now);
  void Seek();

  const MonotonicClock& clock_;
  const Open again_;
  const EvdevSettings settings_;
  const std::string name_;
  std::unique_ptr<EventSource> source_;  ///< null while it is lost
  EvdevSampler sampler_;
  double rumble_ = 0;  ///< last strength sent
  Time rumbled_{};     ///< time of sending it
  rt::LatestValue<teleop::OperatorSample> samples_;
  rt::LatestValue<teleop::OperatorFeedback> felt_;
  std::atomic<bool> lost_{false};
  std::jthread thread_;  ///< last: it uses all members above
};

/// The device "evdev". Parameters: path, or name (part of it), or the first one found; axes,
/// buttons, full_rumble (README.md). @throws InputError for a parameter, in lockstep, and for a
/// missing device, listing those present; EnvironmentError if reading is not permitted.
[[nodiscard]] std::unique_ptr<teleop::Device> MakeEvdevDevice(const teleop::DeviceRequest& request);

}  // namespace twin::devices

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
  EvdevProfile profile{};   ///< what its axes and keys mean
  std::string where{};      ///< for people: "/dev/input/event5"
  double full_rumble = 10;  ///< force at the handle that rumbles at full strength, N; 0: never
};

/// A SpaceMouse or a gamepad, by Linux's input devices.
///
///     events --> thread of its own --LatestValue--> Read()
///     rumble <-- thread of its own <--LatestValue-- Feel()
///
/// A sample comes with every report of the device, and every kPeriod without one: as long as it is
/// plugged in, it has something to say. When it is unplugged, it is lost, and sought again every
/// kRetry; when it comes back, samples go on, with everything let go and no press more.
///
/// Threads: Read() and Feel() from one; lost() and Describe() from any. Real-time: Read() and
/// Feel() exchange values with the thread, nothing else.
class EvdevDevice final : public teleop::Device {
 public:
  static constexpr Duration kPeriod = std::chrono::milliseconds(10);
  static constexpr Duration kRetry = std::chrono::milliseconds(500);

  /// Opens the device again. @throws twin::Error when it is not there.
  using Open = std::function<std::unique_ptr<EventSource>()>;

  /// @param clock  must outlive this. @param again  called on the device's own thread.
  EvdevDevice(const MonotonicClock& clock, std::unique_ptr<EventSource> source, Open again,
              EvdevSettings settings);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override;
  [[nodiscard]] bool lost() const noexcept override {
    return lost_.load(std::memory_order_acquire);  // samples of before are not newer than it
  }
  [[nodiscard]] std::string Describe() const override;

 private:
  void Run(const std::stop_token& stop);
  /// Reads and publishes until the device goes, or `stop`.
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
  double rumble_ = 0;  ///< strength it was told last
  Time rumbled_{};     ///< when
  rt::LatestValue<teleop::OperatorSample> samples_;
  rt::LatestValue<teleop::OperatorFeedback> felt_;
  std::atomic<bool> lost_{false};
  std::jthread thread_;  ///< last: it uses all of the above
};

/// The device "evdev". Parameters: path, or name (part of it), or the first there is; axes,
/// buttons, full_rumble (README.md). @throws InputError for a parameter, in lockstep, and when
/// there is no such device, naming those there are; EnvironmentError when it may not be read.
[[nodiscard]] std::unique_ptr<teleop::Device> MakeEvdevDevice(const teleop::DeviceRequest& request);

}  // namespace twin::devices

#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "twin/core/time.h"
#include "twin/teleop/device.h"
#include "twin/teleop/device_registry.h"

namespace twin::devices {

/// Options of a replay.
struct ScriptSettings {
  /// Interval after which the newest sample is repeated under a new sequence, for handwritten
  /// scripts with few rows. Zero: never, for recordings.
  Duration repeat{};
  /// After the last row: comes to rest and presses the session's end, unless the script did. False:
  /// the device is lost.
  bool ends = true;
};

/// Replays a recorded or written operator: gives a script's samples at their times, counted from
/// the first Read(). Depends only on the script and the times of Read().
///
/// Between two calls only the newest sample is given; presses are counters, so none is missed.
/// A wire could lose the end's press in the last sample: it is repeated, with new sequences, every
/// kHeartbeat for kEndLasts. lost(): permanently after the last sample, or after kEndLasts.
///
/// Threads: Read() and Feel() from one; lost() from any. Real-time: as Device.
class ScriptDevice final : public teleop::Device {
 public:
  /// Time from the last row to the end's press.
  static constexpr Duration kEndAfter = std::chrono::milliseconds(100);
  static constexpr Duration kHeartbeat = std::chrono::milliseconds(33);
  static constexpr Duration kEndLasts = std::chrono::seconds(5);

  /// @param samples  as from ReadOperatorScript. @param name  for users.
  /// @pre samples are not empty.
  ScriptDevice(std::vector<teleop::OperatorSample> samples, std::string name,
               const ScriptSettings& settings);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& /*feedback*/) noexcept override {}
  [[nodiscard]] bool lost() const noexcept override {
    return lost_.load(std::memory_order_relaxed);  // relaxed: publishes no other data
  }
  [[nodiscard]] std::string Describe() const override;

 private:
  [[nodiscard]] teleop::OperatorSample Give(Time now) noexcept;
  /// Time after which the newest sample is repeated; zero: never.
  [[nodiscard]] Duration Pause() const noexcept;

  std::vector<teleop::OperatorSample> samples_;
  const std::string name_;
  const Duration repeat_;
  std::optional<Time> begun_;   ///< time of the first Read()
  Time given_{};                ///< time of the last given sample
  std::size_t next_ = 0;        ///< next sample to give
  std::uint64_t sequence_ = 0;  ///< of the newest given sample
  std::atomic<bool> lost_{false};
};

/// The device "script". Parameters: file (relative to the request's folder), repeat, at_end
/// (README.md).
/// @throws InputError for a parameter, or for the file.
[[nodiscard]] std::unique_ptr<teleop::Device> MakeScriptDevice(
    const teleop::DeviceRequest& request);

}  // namespace twin::devices

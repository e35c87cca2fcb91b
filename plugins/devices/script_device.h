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

/// How a script is replayed.
struct ScriptSettings {
  /// The newest sample is given again, under a new sequence, when none has been for so long: what a
  /// person wrote by hand has few rows. Zero: never, as a recording is replayed.
  Duration repeat{};
  /// After the last row: at rest, and the session's end is pressed, unless the script did. False:
  /// the device is lost.
  bool ends = true;
};

/// A recorded or written operator: gives a script's samples at their times, counted from the first
/// Read(). What it gives depends on the script and on the times of Read() alone.
///
/// Of samples between two calls the newest is given; presses are counters, and none is missed. What
/// a wire would lose is told again, under new sequences, every kHeartbeat: the end once it is
/// pressed in the last sample, for kEndLasts; and before a first row that has presses a sample at
/// rest without them, from which they count. That row is given kLead after the first Read() or
/// later, all others as long after it as they are in the script.
/// lost(): for ever from the call after the last sample on, or after kEndLasts.
///
/// Threads: Read() and Feel() from one; lost() from any. Real-time: as Device.
class ScriptDevice final : public teleop::Device {
 public:
  /// How long after the last row the end is pressed.
  static constexpr Duration kEndAfter = std::chrono::milliseconds(100);
  static constexpr Duration kHeartbeat = std::chrono::milliseconds(33);
  static constexpr Duration kEndLasts = std::chrono::seconds(5);
  static constexpr Duration kLead = std::chrono::milliseconds(330);

  /// @param samples  as ReadOperatorScript gives them. @param name  for people.
  /// @pre samples are not empty.
  ScriptDevice(std::vector<teleop::OperatorSample> samples, std::string name,
               const ScriptSettings& settings);

  [[nodiscard]] std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& /*feedback*/) noexcept override {}
  [[nodiscard]] bool lost() const noexcept override {
    return lost_.load(std::memory_order_relaxed);  // alone: nothing else is published with it
  }
  [[nodiscard]] std::string Describe() const override;

 private:
  [[nodiscard]] teleop::OperatorSample Give(Time now) noexcept;
  /// After which the newest is given again; zero: never.
  [[nodiscard]] Duration Pause() const noexcept;

  std::vector<teleop::OperatorSample> samples_;
  const std::string name_;
  const Duration repeat_;
  bool has_lead_ = false;       ///< the first sample is the one before a row with presses
  std::optional<Time> begun_;   ///< when Read() was called first
  Time given_{};                ///< when a sample was, last
  std::size_t next_ = 0;        ///< sample that was not reached yet
  std::uint64_t sequence_ = 0;  ///< of the newest that was given
  std::atomic<bool> lost_{false};
};

/// The device "script". Parameters: file (against the request's folder), repeat, at_end
/// (README.md). @throws InputError for a parameter, or in the file.
[[nodiscard]] std::unique_ptr<teleop::Device> MakeScriptDevice(
    const teleop::DeviceRequest& request);

}  // namespace twin::devices

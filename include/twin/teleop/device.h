#pragma once

#include <optional>
#include <string>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/teleop/operator_sample.h"

namespace twin::teleop {

/// What an operator holds in the hands. A plug-in (plugins/devices); the only seam to it.
///
/// A living device gives samples at least every 50 ms, whether or not anything moves: silence is
/// how a robot learns that nobody leads it any more.
///
/// Threads: Read() and Feel() from one thread. What a device does on threads of its own is its own
/// affair. Real-time: both noexcept, allocate nothing, wait for nobody.
class Device {
 public:
  virtual ~Device() = default;

  /// @param now  of the run.
  /// @returns the newest sample if there is one since the last call.
  [[nodiscard]] virtual std::optional<OperatorSample> Read(Time now) noexcept TWIN_REALTIME = 0;

  /// Makes it felt, where the device can; shown, where it can.
  virtual void Feel(const OperatorFeedback& feedback) noexcept TWIN_REALTIME = 0;

  /// Whether it has been unplugged, or its connection has ended.
  [[nodiscard]] virtual bool lost() const noexcept TWIN_REALTIME = 0;

  /// For people: "SpaceMouse Compact at /dev/input/event5".
  [[nodiscard]] virtual std::string Describe() const = 0;
};

}  // namespace twin::teleop

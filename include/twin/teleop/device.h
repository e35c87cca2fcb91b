#pragma once

#include <optional>
#include <string>

#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/teleop/operator_sample.h"

namespace twin::teleop {

/// An operator's input device. Implemented by plug-ins (plugins/devices); the only seam to them.
///
/// A working device gives a sample at least every 50 ms, even without motion: a robot detects the
/// operator's absence by silence.
///
/// Threads: Read() and Feel() from one thread; a device may have threads of its own. Real-time:
/// both are noexcept, do not allocate and never wait.
class Device {
 public:
  virtual ~Device() = default;

  /// @param now  time of the run.
  /// @returns the newest sample since the last call; nullopt without one.
  [[nodiscard]] virtual std::optional<OperatorSample> Read(Time now) noexcept TWIN_REALTIME = 0;

  /// Renders the feedback as force or display, as far as the device can.
  virtual void Feel(const OperatorFeedback& feedback) noexcept TWIN_REALTIME = 0;

  /// After the last Read(): completes what it writes. Not real-time; other calls have no effect.
  /// @throws EnvironmentError if something is missing.
  virtual void Finish() {}

  /// True once it has been unplugged or its connection has ended.
  [[nodiscard]] virtual bool lost() const noexcept TWIN_REALTIME = 0;

  /// For users: "SpaceMouse Compact at /dev/input/event5".
  [[nodiscard]] virtual std::string Describe() const = 0;
};

}  // namespace twin::teleop

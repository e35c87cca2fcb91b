#pragma once

#include <array>
#include <optional>

#include "twin/core/time.h"
#include "twin/teleop/operator_sample.h"

namespace twin::devices {

/// What two buttons say, which is more than two things:
///   - left, pressed and let go: the gripper; right: switch between arm and base;
///   - both at once: emergency stop, at once;
///   - in an emergency stop, left held for kHold: its release; right: the end of the session.
/// A button that took part in any of the latter says nothing when it is let go. Our own decision:
/// what stops must be what a startled hand does, and what releases must be what it does not.
///
/// Threads: one.
class TwoButtons {
 public:
  static constexpr Duration kHold = std::chrono::seconds(2);

  /// A button has changed. @param button  0 left, 1 right. @param sample  gets what it says.
  void Press(int button, bool is_down, Time now, teleop::OperatorSample& sample) noexcept;

  /// Time has passed. @param is_stopped  as the robot says.
  void Pass(Time now, bool is_stopped, teleop::OperatorSample& sample) noexcept;

  /// The device has gone: nothing is held.
  void LetGo() noexcept { down_ = {}; }

 private:
  struct Down {
    Time since{};
    bool is_used = false;  ///< it has said something already
  };
  std::array<std::optional<Down>, 2> down_;
};

}  // namespace twin::devices

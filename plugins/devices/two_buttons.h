#pragma once

#include <array>
#include <optional>

#include "twin/core/time.h"
#include "twin/teleop/operator_sample.h"

namespace twin::devices {

/// Meanings of two buttons:
///   - left, pressed and released: the gripper; right: switch between arm and base;
///   - both together: emergency stop, at once;
///   - in an emergency stop, left held for kHold: its release; right: the end of the session.
/// A button used in the latter two has no effect when released. A decision: a startled hand must
/// stop, and must not release.
///
/// Threads: one.
class TwoButtons {
 public:
  static constexpr Duration kHold = std::chrono::seconds(2);

  /// A button has changed. @param button  0 left, 1 right. @param sample  receives its meaning.
  void Press(int button, bool is_down, Time now, teleop::OperatorSample& sample) noexcept;

  /// Time has advanced. @param is_stopped  as reported by the robot.
  void Pass(Time now, bool is_stopped, teleop::OperatorSample& sample) noexcept;

  /// The device was unplugged: no button is held.
  void LetGo() noexcept { down_ = {}; }

 private:
  struct Down {
    Time since{};
    bool is_used = false;  ///< it has already had an effect
  };
  std::array<std::optional<Down>, 2> down_;
};

}  // namespace twin::devices

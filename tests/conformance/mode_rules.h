#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "twin/core/modes.h"

namespace twin::test {

/// Everything that can be asked of the robot through its backend and its panel.
enum class Ask : std::uint8_t {
  kMove,
  kStopMove,
  kSet,
  kAutomaticErrorRecovery,
  kPressUserStop,
  kReleaseUserStop,
  kCloseBrakes,
  kOpenBrakes,
  kPressGuidingButton,
  kReleaseGuidingButton,
};

inline constexpr std::size_t kAsks = 10;
inline constexpr std::size_t kModes = 7;

/// In words: "Move", "Set requests", "press_user_stop", ...
[[nodiscard]] std::string_view Name(Ask ask);

[[nodiscard]] Ask AskOf(PanelAction action);

/// A situation requests can come in: the robot's mode, whether its reference rests, and what is
/// behind the mode.
struct Situation {
  RobotMode mode = RobotMode::kIdle;
  bool at_rest = true;
  bool has_errors = false;     ///< recovery has not been done yet
  bool brakes_closed = false;  ///< by the switch
};

/// What a request comes to.
struct Outcome {
  bool accepted = false;
  RobotMode mode = RobotMode::kIdle;  ///< in the next state, when nothing else happens
};

/// The outcome of every request in every situation, written down from FCI protocol 5 (user stop,
/// guiding, brakes, recovery; what users report of refused requests), without a look at INT's own
/// table.
[[nodiscard]] Outcome Expect(const Situation& situation, Ask ask);

}  // namespace twin::test

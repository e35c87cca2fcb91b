#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "twin/core/modes.h"

namespace twin::onboard {

/// All requests to INT: those of FCI, then the panel's actions in the order of PanelAction.
enum class Request : std::uint8_t {
  kMove,
  kStopMove,
  kGetCartesianLimit,
  kSet,  ///< every Setting
  kAutomaticErrorRecovery,
  kLoadModelLibrary,
  kPressUserStop,
  kReleaseUserStop,
  kCloseBrakes,
  kOpenBrakes,
  kPressGuidingButton,
  kReleaseGuidingButton,
};

inline constexpr std::size_t kRequests = 12;
inline constexpr std::size_t kRobotModes = 7;

/// INT's answer as far as its mode decides it. A granted request can still fail for its arguments.
enum class Verdict : std::uint8_t {
  kGranted,
  kGrantedAtRest,       ///< granted if the reference is at rest, else refused
  kNothingToDo,         ///< succeeds without effect
  kNothingUnlessError,  ///< the same without an error, refused with one
  kRefused,
};

/// The verdict of every request (column) in every mode (row): the whole of INT's mode logic.
///
///   mode       | Move | StopMove | setters | recovery | user stop: press, release |
///   Other      | -    | .        | x       | e        | x  .   brakes closed
///   Idle       | r    | .        | x       | .        | x  .
///   Move       | -    | x        | -       | -        | x  .
///   Guiding    | -    | .        | x       | e        | x  .
///   Reflex     | -    | .        | -       | r        | x  .
///   UserStopped| -    | .        | x       | -        | .  r
///   Recovery   | -    | .        | -       | -        | x  .
///     x granted, r granted at rest, . nothing to do, e nothing to do unless there is an error, -
///     refused
///
/// A successful recovery clears all errors. With an error, recovery is refused while people lead
/// the arm or its brakes are closed; it is granted in Reflex, which the robot enters afterwards.
///
/// Brakes close from Idle and Reflex, at rest, and open from Other. Guiding starts from Idle and,
/// so that people can free the arm, from Reflex, at rest. GetCartesianLimit and LoadModelLibrary
/// are always granted.
///
/// Users of the robot report which modes refuse a Move, and that setters are refused in Move and
/// Reflex. StopMove always succeeds, since clients terminate otherwise. The other entries are
/// decisions, as nothing is published. Source: FCI protocol 5, user stop, guiding, brakes,
/// recovery.
inline constexpr std::array<std::array<Verdict, kRequests>, kRobotModes> kModeTable = [] {
  constexpr Verdict x = Verdict::kGranted;
  constexpr Verdict r = Verdict::kGrantedAtRest;
  constexpr Verdict o = Verdict::kNothingToDo;
  constexpr Verdict e = Verdict::kNothingUnlessError;
  constexpr Verdict n = Verdict::kRefused;
  // Move Stop Lim Set Rec Lib | US+ US- Br+ Br- Gd+ Gd-
  return std::array<std::array<Verdict, kRequests>, kRobotModes>{{
      {n, o, x, x, e, x, x, o, o, x, n, o},  // Other
      {r, o, x, x, o, x, x, o, r, o, r, o},  // Idle
      {n, x, x, n, n, x, x, o, n, o, n, o},  // Move
      {n, o, x, x, e, x, x, o, n, o, o, x},  // Guiding
      {n, o, x, n, r, x, x, o, r, o, r, o},  // Reflex
      {n, o, x, x, n, x, o, r, n, n, n, o},  // UserStopped
      {n, o, x, n, n, x, x, o, n, o, n, o},  // AutomaticErrorRecovery
  }};
}();

/// Threads: any. Real-time: noexcept, O(1).
[[nodiscard]] constexpr Verdict VerdictOn(RobotMode mode, Request request) noexcept {
  return kModeTable[static_cast<std::size_t>(mode)][static_cast<std::size_t>(request)];
}

[[nodiscard]] constexpr Request RequestOf(PanelAction action) noexcept {
  return static_cast<Request>(static_cast<int>(Request::kPressUserStop) + static_cast<int>(action));
}

/// The whole table as Markdown: a row per request, a column per mode.
[[nodiscard]] std::string ModeTable();

/// The table's name: "Move", "Set requests", "press_user_stop", ...
[[nodiscard]] std::string_view Name(Request request) noexcept;
/// "granted", "granted at rest", "nothing to do", "nothing to do; refused with an error",
/// "refused".
[[nodiscard]] std::string_view Name(Verdict verdict) noexcept;

}  // namespace twin::onboard

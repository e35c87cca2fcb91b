#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "twin/core/joint_vector.h"

namespace twin::server {

/// What a control channel (control_channel.h) is asked to do.
enum class ControlVerb : std::uint8_t {
  kStatus,    ///< nothing: the answer says how the robot is
  kPause,     ///< lockstep: time stands still
  kStep,      ///< lockstep: `cycles` more, and time stands still again
  kResume,    ///< lockstep: time runs
  kUserStop,  ///< presses (`on`) or releases the user stop
  kGuiding,   ///< presses (`on`) or releases the guiding button
  kRecover,   ///< automatic error recovery
  kReset,     ///< lockstep: the robot begins anew, the arm at `q`
  kPlace,     ///< puts the scene's object `name` at rest at `position`, `rpy`
  kSnapshot,  ///< lockstep: keeps a copy of the whole twin as `name`
  kRestore,   ///< lockstep: goes back to the copy `name`
};

/// Whether the robot goes on with it once it is granted (ControlledRobot::IsBusy): its answer comes
/// when that has ended.
[[nodiscard]] bool TakesTime(ControlVerb verb) noexcept;

/// A request to a control channel.
struct ControlRequest {
  /// A day of the robot's time.
  static constexpr std::uint64_t kMostCycles = 86'400'000;
  static constexpr double kFarthest = 100;          ///< m
  static constexpr std::size_t kLongestName = 64;   ///< bytes, all printable
  static constexpr const char* kSnapshot = "last";  ///< a snapshot's name without one

  ControlVerb verb = ControlVerb::kStatus;
  std::uint64_t cycles = 1;        ///< of kStep, in [1, kMostCycles]
  bool on = false;                 ///< of kUserStop and kGuiding
  std::optional<JointVector> q{};  ///< of kReset, rad, finite; absent: the scenario's start
  std::string name{};              ///< of kPlace, kSnapshot and kRestore, in [1, kLongestName]
  Vector3 position{};              ///< of kPlace, in the world, m, each at most kFarthest away
  Vector3 rpy{};                   ///< of kPlace, roll, pitch, yaw: R = Rz Ry Rx, rad, finite
  bool operator==(const ControlRequest&) const = default;
};

/// Reads a request from a line of JSON without its end: {"do": "step", "cycles": 10},
/// {"do": "user-stop", "on": true}, {"do": "reset", "q": [0, ...]}, {"do": "pause"},
/// {"do": "place", "name": "box", "position": [0.5, 0, 0.1], "rpy": [0, 0, 1.57]} (level without
/// rpy), {"do": "snapshot", "name": "grasped"}. The line may hold any bytes.
///
/// Threads: any. @throws InputError, in one printable line, for what is not a JSON object, a verb
/// that does not exist (lists them), a key that the verb does not have, and a value out of range.
[[nodiscard]] ControlRequest ParseControlRequest(std::string_view line);

/// The same from the words of a command line: step 10, user-stop press, guiding off, reset, reset
/// ready (Franka's ready pose), reset with seven angles in rad, pause, place box 0.5 0 0.1 [0 0
/// 1.57], snapshot [NAME], restore [NAME].
/// @throws InputError as ParseControlRequest().
[[nodiscard]] ControlRequest ControlRequestOf(std::span<const std::string> words);

/// The line that ParseControlRequest() reads as this request, without its end.
[[nodiscard]] std::string ToLine(const ControlRequest& request);

}  // namespace twin::server

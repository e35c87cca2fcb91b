#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "twin/core/robot_errors.h"

namespace twin {

/// What the axis of a violation counts.
enum class AxisKind : std::uint8_t {
  kNone,    ///< nothing single is to blame
  kJoint,   ///< 0..6: joint 1 to 7
  kMotion,  ///< 0..2: translation, rotation, elbow
  kWrench,  ///< 0..5: x y z R P Y of K
};

/// What keeps time in a run: it decides where to look for what went wrong.
enum class TimeKeeper : std::uint8_t {
  kVirtualClock,  ///< lockstep: delays and losses are those of the scenario
  kWallClock,     ///< real time: the host has its share
};

/// What there is to know about an error, in words for people. Texts are English, without a full
/// stop at their end; what does not apply is empty.
///
/// Quantities are those of the robot state; q_d, dq_d, O_dP_EE_c and the like are as the last state
/// reports them.
struct ErrorEntry {
  bool raised = false;                      ///< by the controller here, in motions over FCI
  AxisKind axis = AxisKind::kNone;          ///< what its violations are sorted by
  std::string_view meaning{};               ///< what happened
  std::string_view quantity{};              ///< what was compared with the limit
  std::array<std::string_view, 3> units{};  ///< of it: one for all axes, or one for each of
                                            ///< kMotion; kWrench: of forces, of torques
  std::string_view computed{};              ///< how it came about
  std::string_view cause{};                 ///< what usually leads to it; not raised: why it is not
  std::string_view cure{};                  ///< what helps on any robot
  std::string_view in_scenario{};           ///< what helps in a scenario, lockstep
  std::string_view in_realtime{};           ///< what helps in a run in real time
};

/// The entry of an error. @pre error is one of the kRobotErrorCount.
[[nodiscard]] const ErrorEntry& EntryOf(RobotError error) noexcept;

/// Axis of a communication error whose cause is that the motion's first command did not come; -1
/// when too many commands in a row were lost.
inline constexpr std::int8_t kNoFirstCommandAxis = 0;

/// Axis of an instability that is no arm that will not rest, which names its fastest joint, but a
/// measured or computed value that is no number.
inline constexpr std::int8_t kNoNumberAxis = -1;

/// The entry that explains a violation: that of its error, or, of communication errors and
/// instabilities, of the one of the two causes that it had (kNoFirstCommandAxis, kNoNumberAxis).
[[nodiscard]] const ErrorEntry& EntryOf(const Violation& violation) noexcept;

/// "joint 2", "rotation", "z of K"; empty when nothing single is to blame.
[[nodiscard]] std::string AxisName(const Violation& violation);

/// The unit of value and limit: "rad/s^2"; empty when they have none.
[[nodiscard]] std::string_view UnitOf(const Violation& violation) noexcept;

/// What helps in a run with this keeper of time; where there is nothing of its own, the cure.
[[nodiscard]] std::string_view CureHere(const ErrorEntry& entry, TimeKeeper keeper) noexcept;

/// All that can be done about it, in one text: the cure, and what helps with this keeper of time.
[[nodiscard]] std::string CureOf(const ErrorEntry& entry, TimeKeeper keeper);

/// The whole catalogue in Markdown, in the order of the errors: documentation.
[[nodiscard]] std::string ErrorCatalogue();

}  // namespace twin

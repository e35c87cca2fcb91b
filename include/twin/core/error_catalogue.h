#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "twin/core/robot_errors.h"

namespace twin {

/// Meaning of a violation's axis.
enum class AxisKind : std::uint8_t {
  kNone,    ///< no single axis
  kJoint,   ///< 0..6: joint 1 to 7
  kMotion,  ///< 0..2: translation, rotation, elbow
  kWrench,  ///< 0..5: x y z R P Y of K
};

/// Clock of a run; it determines where to look for a cause.
enum class TimeKeeper : std::uint8_t {
  kVirtualClock,  ///< lockstep: delays and losses come from the scenario
  kWallClock,     ///< real time: the host adds its own
};

/// Explanation of an error for users. Texts are English without a final full stop; texts that do
/// not apply are empty.
///
/// Quantities are those of the robot state; q_d, dq_d, O_dP_EE_c etc. are those of the last state.
struct ErrorEntry {
  bool raised = false;                      ///< by this controller, in motions over FCI
  AxisKind axis = AxisKind::kNone;          ///< axis of its violations
  std::string_view meaning{};               ///< what happened
  std::string_view quantity{};              ///< the quantity compared with the limit
  std::array<std::string_view, 3> units{};  ///< one for all axes; kMotion: or one per axis;
                                            ///< kWrench: force, torque
  std::string_view computed{};              ///< how it is computed
  std::string_view cause{};                 ///< usual cause; not raised: the reason why
  std::string_view cure{};                  ///< remedy on any robot
  std::string_view in_scenario{};           ///< remedy in a scenario, lockstep
  std::string_view in_realtime{};           ///< remedy in a real-time run
};

/// The entry of an error. @pre error is one of the kRobotErrorCount.
[[nodiscard]] const ErrorEntry& EntryOf(RobotError error) noexcept;

/// Axis of a communication error whose motion's first command did not arrive; -1 when too many
/// consecutive commands were lost.
inline constexpr std::int8_t kNoFirstCommandAxis = 0;

/// Axis of an instability caused by a value that is not finite, measured or computed. Without one,
/// the axis is the fastest joint of an arm that does not come to rest.
inline constexpr std::int8_t kNoNumberAxis = -1;

/// The entry that explains a violation: that of its error, or, for communication errors and
/// instabilities, that of its cause (kNoFirstCommandAxis, kNoNumberAxis).
[[nodiscard]] const ErrorEntry& EntryOf(const Violation& violation) noexcept;

/// "joint 2", "rotation", "z of K"; empty without a single axis.
[[nodiscard]] std::string AxisName(const Violation& violation);

/// Unit of value and limit: "rad/s^2"; empty if dimensionless.
[[nodiscard]] std::string_view UnitOf(const Violation& violation) noexcept;

/// The remedy specific to this clock, else the general cure.
[[nodiscard]] std::string_view CureHere(const ErrorEntry& entry, TimeKeeper keeper) noexcept;

/// All remedies in one text: the cure, then that specific to this clock.
[[nodiscard]] std::string CureOf(const ErrorEntry& entry, TimeKeeper keeper);

/// The whole catalogue as Markdown, in the order of the errors.
[[nodiscard]] std::string ErrorCatalogue();

}  // namespace twin

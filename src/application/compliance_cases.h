#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string_view>

#include "twin/control/parameters.h"
#include "twin/core/joint_vector.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/plant/perturbation.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"

namespace twin::application {
class Stage;
}

// What is done in the application `compliance`: its cases, their motions, and who pushes when.
namespace twin::application::compliance {

/// A spring and a damper of the end effector along (N/m, Ns/m) and about (Nm/rad, Nms/rad) the
/// base's axes.
struct Gains {
  Vector6 K_P{};
  Vector6 K_D{};
};

/// The parameters; in brackets their keys. The defaults of gains and null space are the paper's.
struct Settings {
  Gains stiff{.K_P = {1000, 1000, 1000, 100, 100, 100}, .K_D = {100, 100, 100, 10, 10, 10}};
  Gains compliant{.K_P = {100, 100, 100, 10, 10, 10}, .K_D = {10, 10, 10, 5, 5, 5}};
  double k_0 = 1;  ///< Nm/rad [k0]
  JointVector q_0{0, 0, 0, -std::numbers::pi / 2, 0, 107 * std::numbers::pi / 180, 0};  ///< [q0]
  /// Share of the joints' friction that the controller makes up for, in [0, 1]; absent: what the
  /// robot leaves of it.
  std::optional<double> friction_compensation{};
  Duration soft_start = std::chrono::milliseconds(1500);
  Duration standing = std::chrono::seconds(12);  ///< how long a case at a standstill takes

  /// The trajectory: to `first`, by `second` from there, straight back; base axes, m.
  Vector3 first{0, 0.15, 0};
  Vector3 second{0.1, -0.075, -0.1};
  Duration leg = std::chrono::seconds(5);   ///< each of its three parts
  Duration rest = std::chrono::seconds(2);  ///< at its end

  /// The null space's demonstration: another place for the elbow [null_space: {q0, duration}].
  JointVector elsewhere{
      std::numbers::pi / 3,         0, -std::numbers::pi / 3, -std::numbers::pi / 2, 0,
      107 * std::numbers::pi / 180, 0};
  Duration wandering = std::chrono::seconds(8);
};

/// @throws InputError naming place, key, value and range.
[[nodiscard]] Settings ReadSettings(control::ParameterReader& parameters);

enum class Kind : std::uint8_t { kStandstill, kTrajectory, kNullSpace };

/// One of the application's motions. Between two of them the arm goes back to where it began, in a
/// motion of its own, so that cases have odd numbers.
struct Case {
  std::string_view id;
  std::string_view what;
  Kind kind = Kind::kStandstill;
  bool is_stiff = true;
  bool is_pushed = false;
  std::uint32_t motion = 0;  ///< as plant::Push::motion
};

enum CaseIndex : std::size_t { kA, kB, kC0, kC, kD0, kD, kN, kCases };

inline constexpr std::array<Case, kCases> kAllCases{{
    {"A", "standstill, stiff, pushed", Kind::kStandstill, true, true, 1},
    {"B", "standstill, compliant, pushed", Kind::kStandstill, false, true, 3},
    {"C0", "trajectory, stiff, untouched", Kind::kTrajectory, true, false, 5},
    {"C", "trajectory, stiff, pushed", Kind::kTrajectory, true, true, 7},
    {"D0", "trajectory, compliant, untouched", Kind::kTrajectory, false, false, 9},
    {"D", "trajectory, compliant, pushed", Kind::kTrajectory, false, true, 11},
    {"N", "standstill, stiff, null space pulls elsewhere", Kind::kNullSpace, true, false, 13},
}};

[[nodiscard]] const Gains& GainsOf(const Case& one, const Settings& settings) noexcept;

/// How long a case's motion takes by its plan, without the controller's settling.
[[nodiscard]] Duration LengthOf(const Case& one, const Settings& settings) noexcept;

/// The motion of a case that begins where the robot is.
/// @throws InputError when its path breaks a limit of the end effector's motion.
[[nodiscard]] run::Motion MotionOf(const Case& one, const Settings& settings, const Stage& stage,
                                   const RobotState& state);

/// The motion back to robot.q_start, by torques as well.
[[nodiscard]] run::Motion MotionBack(const Case& from, const Stage& stage, const RobotState& state);

/// Who pushes: the same at A and B, the same at C and D.
struct Pushes {
  plant::Push standing;
  plant::Push moving;
};

/// Time before a push whose mean is what it deflects from, and at the end of its constant part
/// whose mean is the steady deflection.
inline constexpr Duration kBefore = std::chrono::milliseconds(500);
inline constexpr Duration kSteady = std::chrono::seconds(1);

/// The scenario's pushes.
/// @throws InputError when a pushed case has none or more than one, another motion has one, A's
/// differs from B's or C's from D's, or one is not such that its deflection can be measured.
[[nodiscard]] Pushes PushesOf(const scenario::Scenario& scenario, const Settings& settings);

}  // namespace twin::application::compliance

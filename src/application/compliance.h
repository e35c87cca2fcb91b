#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

#include "twin/application/application.h"
#include "twin/control/parameters.h"
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/plant/perturbation.h"
#include "twin/reference/pose_trajectory.h"
#include "twin/run/session.h"
#include "twin/scenario/scenario.h"

// The parts of the application `compliance`: cases and pushes, traces from the log, measures,
// evaluation.
namespace twin::application::compliance {

/// A spring and a damper of the end effector along (N/m, Ns/m) and about (Nm/rad, Nms/rad) the
/// base's axes.
struct Gains {
  Vector6 K_P{};
  Vector6 K_D{};
};

/// The parameters; in brackets their keys. The defaults of gains and null space are the paper's.
struct Config {
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
[[nodiscard]] Config ReadConfig(control::ParameterReader& parameters);

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

[[nodiscard]] const Gains& GainsOf(const Case& one, const Config& config) noexcept;

/// How long a case's motion takes by its plan, without the controller's settling.
[[nodiscard]] Duration LengthOf(const Case& one, const Config& config) noexcept;

/// The motion of a case that begins where the robot is.
/// @throws InputError when its path breaks a limit of the end effector's motion.
[[nodiscard]] run::Motion MotionOf(const Case& one, const Config& config, const Stage& stage,
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
[[nodiscard]] Pushes PushesOf(const scenario::Scenario& scenario, const Config& config);

/// One state of a case's motion.
struct Sample {
  std::uint64_t cycle = 0;  ///< ms since the motion's first state
  double at = 0;            ///< s, of the session
  Vector3 p{};              ///< of the end effector, m
  Vector3 off{};            ///< p - p_d, from its reference, m
  double turned = 0;        ///< from its reference, rad
  Vector3 force{};          ///< on the arm, as the robot estimates it: -O_F_ext_hat_K, N
  double torque = 0;        ///< largest of |tau_J| and |tau_J_d| over their limits, of all joints
  double rate = 0;          ///< largest of |d tau_J_d / dt| over its limit
  JointVector q{};          ///< rad

  /// Since the motion's first state, s.
  [[nodiscard]] double t() const noexcept { return 1e-3 * static_cast<double>(cycle); }
};

/// A case's motion, as the log has it, in order of time, until its last command: the robot stops
/// the arm by itself. Empty: it was not made.
using Trace = std::vector<Sample>;

/// When a case's motion was under way, and what it followed.
struct Span {
  Time begun{};
  Time ended{};
  std::optional<reference::PoseTrajectory> path{};  ///< absent: the pose it began at
};

/// What the log says of the cases, and of the run as a whole.
struct Log {
  std::array<Trace, kCases> traces{};
  std::uint64_t reflexes = 0;  ///< times the robot stopped by itself
};

/// Reads a log. The reference's time is the session's, which is the controller's, since the first
/// state of the motion, in which the controller begins, to about a millisecond. A push's time is
/// the robot's, in cycles: on the wall clock a robot may come to lag.
/// @throws as record::LogReader.
[[nodiscard]] Log ReadLog(const std::filesystem::path& log,
                          const std::array<std::optional<Span>, kCases>& spans,
                          const JointLimits& limits);

/// How the end effector gave way to a push.
///
/// The deflection is what the push alone did: at a standstill the way from the mean pose of the
/// half second before it, on the trajectory the difference of the distances from the reference,
/// pushed and untouched, at the same time of the motion. So what the robot's model of gravity is
/// wrong by, which moves a soft spring as well, is no part of it.
struct Response {
  std::vector<double> t{};          ///< since the motion began, s
  std::vector<double> along{};      ///< deflection along the push, m
  std::vector<double> across{};     ///< the rest of it, magnitude, m
  std::vector<double> scripted{};   ///< force of the push, N
  std::vector<double> estimated{};  ///< along the push, as the robot estimates it, in the same way
  double peak = 0;                  ///< largest deflection along the push, m
  double steady = 0;                ///< its mean over the last second of constant force, m
  double expected = 0;              ///< F / K, m
  double force = 0;                 ///< F, N
  double estimated_steady = 0;      ///< of the force, over the same second, N
  /// From the end of the push until the deflection stays within a tenth of the steady one, s;
  /// absent: it had not by the motion's end.
  std::optional<double> settling{};
};

/// How well a reference was followed.
struct Tracking {
  double largest = 0;         ///< m
  double rms = 0;             ///< m
  double largest_turned = 0;  ///< rad
};

/// What the null space did, from half a second after the soft start on: before that, the spring
/// takes over the weight that the robot's model is wrong by.
struct Wandering {
  double joints = 0;        ///< largest way of a joint, rad
  double end_effector = 0;  ///< largest way of the end effector, m
};

/// @param untouched  the same motion without the push; null: the push came at a standstill.
/// @pre pushed is not empty, nor is untouched. @returns nothing when the motion did not come to the
/// push's end.
[[nodiscard]] std::optional<Response> ResponseOf(const Trace& pushed, const Trace* untouched,
                                                 const plant::Push& push, const Gains& gains);

/// @pre the trace is not empty.
[[nodiscard]] Tracking TrackingOf(const Trace& trace);

/// Time in the null space's case from which on its motion counts, s.
[[nodiscard]] double WanderingBegin(const Config& config);
[[nodiscard]] std::optional<Wandering> WanderingOf(const Trace& trace, const Config& config);

/// All that was measured.
struct Measures {
  std::array<std::optional<Response>, kCases> responses{};
  std::array<std::optional<Tracking>, kCases> trackings{};  ///< of untouched trajectories
  std::optional<Wandering> wandering{};
  double torque = 0;  ///< largest share of a limit
  double rate = 0;    ///< largest share of a limit
  std::uint64_t reflexes = 0;
};

[[nodiscard]] Measures Measure(const Log& log, const Config& config, const Pushes& pushes);

/// The demands and further quantities, of the cases that were executed.
[[nodiscard]] Evaluation EvaluateCases(const Measures& measures);

/// The figures for the page, of the cases that were executed.
[[nodiscard]] std::vector<report::Figure> FiguresOf(const Log& log, const Measures& measures,
                                                    const Config& config);

}  // namespace twin::application::compliance

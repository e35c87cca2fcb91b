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
#include "twin/core/joint_vector.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/plant/perturbation.h"
#include "twin/reference/pose_trajectory.h"

// Parts of the application `compliance`: cases, traces from the log, measures, evaluation.
namespace twin::application::compliance {

/// A spring and a damper of the end effector along (N/m, Ns/m) and about (Nm/rad, Nms/rad) the
/// base's axes.
struct Gains {
  Vector6 K_P{};
  Vector6 K_D{};
};

/// The parameters, with their keys in brackets. Default gains and null space are the paper's.
struct Config {
  Gains stiff{.K_P = {1000, 1000, 1000, 100, 100, 100}, .K_D = {100, 100, 100, 10, 10, 10}};
  Gains compliant{.K_P = {100, 100, 100, 10, 10, 10}, .K_D = {10, 10, 10, 5, 5, 5}};
  double k_0 = 1;  ///< Nm/rad [k0]
  JointVector q_0{0, 0, 0, -std::numbers::pi / 2, 0, 107 * std::numbers::pi / 180, 0};  ///< [q0]
  /// Share of the joint friction that the controller compensates, in [0, 1]; absent: the share that
  /// the robot does not compensate.
  std::optional<double> friction_compensation{};
  Duration soft_start = std::chrono::milliseconds(1500);
  Duration standing = std::chrono::seconds(12);  ///< duration of a case at a standstill

  /// The trajectory: by `first`, then by `second`, then straight back; base axes, m.
  Vector3 first{0, 0.15, 0};
  Vector3 second{0.1, -0.075, -0.1};
  Duration leg = std::chrono::seconds(5);   ///< duration of each of its three parts
  Duration rest = std::chrono::seconds(2);  ///< pause at its end

  /// Joint positions that the null space's case pulls to [null_space: {q0, duration}].
  JointVector elsewhere{
      std::numbers::pi / 3,         0, -std::numbers::pi / 3, -std::numbers::pi / 2, 0,
      107 * std::numbers::pi / 180, 0};
  Duration wandering = std::chrono::seconds(8);
};

enum class Kind : std::uint8_t { kStandstill, kTrajectory, kNullSpace };

/// One of the application's motions. A separate motion returns the arm to its start between two
/// cases, so the cases have odd motion numbers. The unpushed trajectory precedes the pushed one.
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

[[nodiscard]] inline const Gains& GainsOf(const Case& one, const Config& config) noexcept {
  return one.is_stiff ? config.stiff : config.compliant;
}

/// The pushes of the pushed cases; A's equals B's, C's equals D's.
using Pushes = std::array<std::optional<plant::Push>, kCases>;

/// Averaging times: before a push, for the pose from which it deflects the arm; at the end of its
/// constant part, for the steady deflection.
inline constexpr Duration kBefore = std::chrono::milliseconds(500);
inline constexpr Duration kSteady = std::chrono::seconds(1);

/// One state of a case's motion.
struct Sample {
  std::uint64_t cycle = 0;  ///< ms since the motion's first state
  double at = 0;            ///< session time, s
  Vector3 p{};              ///< of the end effector, m
  Vector3 off{};            ///< p - p_d, from its reference, m
  double turned = 0;        ///< angle from its reference, rad
  Vector3 force{};          ///< on the arm, as the robot estimates it: -O_F_ext_hat_K, N
  double torque = 0;        ///< largest of |tau_J| and |tau_J_d| over their limits, of all joints
  double rate = 0;          ///< largest of |d tau_J_d / dt| over its limit
  JointVector q{};          ///< rad

  /// Time since the motion's first state, s.
  [[nodiscard]] double t() const noexcept { return 1e-3 * static_cast<double>(cycle); }
};

/// The logged states of a case's motion in order of time, up to its last command, after which the
/// robot stops the arm. Empty: the case was not executed.
using Trace = std::vector<Sample>;

/// Time span and reference of a case's motion.
struct Span {
  Time begun{};
  Time ended{};
  std::optional<reference::PoseTrajectory> path{};  ///< absent: holds the initial pose
};

using Spans = std::array<std::optional<Span>, kCases>;

/// Data from the log: of the cases and of the whole run.
struct Log {
  std::array<Trace, kCases> traces{};
  std::uint64_t reflexes = 0;  ///< number of reflexes of the robot
};

/// Reads a log. The reference's time is the session's (the controller's), counted from the motion's
/// first state, in which the controller begins, to about a millisecond. A push's time is the
/// robot's, in cycles, because a robot on the wall clock may lag.
/// @throws as record::LogReader.
[[nodiscard]] Log ReadLog(const std::filesystem::path& log, const Spans& spans,
                          const JointLimits& limits);

/// Response of the end effector to a push.
///
/// The deflection contains the effect of the push only: at a standstill, the displacement from the
/// mean pose of the half second before it; on the trajectory, the difference between the pushed and
/// the unpushed motion of the deviation from the reference, at the same time of the motion. It
/// therefore excludes errors of the robot's gravity model, which also deflect a soft spring.
struct Response {
  std::vector<double> t{};          ///< since the motion's start, s
  std::vector<double> along{};      ///< deflection along the push, m
  std::vector<double> across{};     ///< magnitude of the deflection across the push, m
  std::vector<double> scripted{};   ///< force of the push, N
  std::vector<double> estimated{};  ///< force along the push, likewise, estimated by the robot, N
  double peak = 0;                  ///< largest deflection along the push, m
  double steady = 0;                ///< mean deflection over the last second of constant force, m
  double expected = 0;              ///< F / K, m
  double force = 0;                 ///< F, N
  double estimated_steady = 0;      ///< mean of the estimated force over the same second, N
  /// Time from the end of the push until the deflection stays within a tenth of the steady one, s;
  /// absent: not settled at the motion's end.
  std::optional<double> settling{};
};

/// Tracking error of a reference.
struct Tracking {
  double largest = 0;         ///< m
  double rms = 0;             ///< m
  double largest_turned = 0;  ///< rad
};

/// Null-space motion from half a second after the soft start on; before, the spring takes the load
/// caused by errors of the robot's gravity model.
struct Wandering {
  double joints = 0;        ///< largest displacement of a joint, rad
  double end_effector = 0;  ///< largest displacement of the end effector, m
};

/// @param untouched  the same motion without the push; null: a push at a standstill.
/// @pre neither trace is empty. @returns nullopt if a motion ended before the push did.
[[nodiscard]] std::optional<Response> ResponseOf(const Trace& pushed, const Trace* untouched,
                                                 const plant::Push& push, const Gains& gains);

/// @pre the trace is not empty.
[[nodiscard]] Tracking TrackingOf(const Trace& trace);

/// Start of the measurement in the null space's case, s.
[[nodiscard]] inline double WanderingBegin(const Config& config) {
  return ToSeconds(config.soft_start + kBefore);
}
[[nodiscard]] std::optional<Wandering> WanderingOf(const Trace& trace, const Config& config);

/// All measurements.
struct Measures {
  std::array<std::optional<Response>, kCases> responses{};
  std::array<std::optional<Tracking>, kCases> trackings{};  ///< of untouched trajectories
  std::optional<Wandering> wandering{};
  double torque = 0;  ///< largest share of a limit
  double rate = 0;    ///< largest share of a limit
  std::uint64_t reflexes = 0;
};

[[nodiscard]] Measures Measure(const Log& log, const Config& config, const Pushes& pushes);

/// Demands and further quantities of the executed cases.
[[nodiscard]] Evaluation EvaluateCases(const Measures& measures);

/// Figures of the executed cases, for the report.
[[nodiscard]] std::vector<report::Figure> FiguresOf(const Log& log, const Measures& measures,
                                                    const Config& config);

}  // namespace twin::application::compliance

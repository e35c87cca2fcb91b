#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "twin/control/controller.h"
#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/mobile_base.h"
#include "twin/core/modes.h"
#include "twin/core/realtime.h"
#include "twin/core/time.h"
#include "twin/loop/deviation.h"
#include "twin/loop/run_report.h"
#include "twin/planning/planner.h"
#include "twin/record/cycle_record.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// How far the arm may be from its target in one motion; infinite where it is not judged.
struct DeviationLimit {
  double joints = std::numeric_limits<double>::infinity();    ///< rad
  double position = std::numeric_limits<double>::infinity();  ///< m
  double angle = std::numeric_limits<double>::infinity();     ///< rad
};

/// Deviation of one motion from its path, and the limit.
struct FollowedMotion {
  std::string name;  ///< empty: the only one
  Time begun{};      ///< of the session
  loop::Deviation deviation;
  DeviationLimit limit;
  bool succeeded = false;  ///< a failed motion is judged by its failure alone

  [[nodiscard]] bool exceeds() const noexcept { return succeeded && !Excess().empty(); }
  /// The values above their limits, as text; empty: none.
  [[nodiscard]] std::string Excess() const;
};

/// The limit of a motion on this interface, which the robot follows by `impedance`: the scenario's
/// max_deviation. The default is 20 mrad, for poses 20 mm and 20 mrad, times the ratio by which the
/// robot is softer than as delivered (onboard.K_theta, onboard.K_x): friction, inertia and loads
/// move the arm by a force over its stiffness. Without max_deviation two kinds are not judged:
/// torques, which are as stiff as their controller, and scenarios with perturbations, which move
/// the arm off its path on purpose.
[[nodiscard]] DeviationLimit LimitOf(const scenario::Scenario& scenario,
                                     control::CommandInterface interface, ControllerMode impedance);

/// Command statistics of a motion, counted by INT.
struct CycleCounts {
  std::uint64_t served = 0;        ///< cycles with a command in time
  std::uint64_t held = 0;          ///< cycles without one
  std::uint64_t dropped = 0;       ///< commands that came late, doubled or with a wrong id
  std::uint64_t longest_loss = 0;  ///< most held cycles in a row

  [[nodiscard]] std::uint64_t cycles() const noexcept { return served + held; }
  /// Share of the cycles without a command, %; 0 of none.
  [[nodiscard]] double unserved_percent() const noexcept;

  /// One cycle more. Real-time: noexcept, allocates nothing.
  void Add(const record::CycleRecord& record) noexcept TWIN_REALTIME;
};

/// Result of a command to the hand.
struct HandOutcome {
  std::optional<Time> begun;          ///< absent: the run ended before
  std::optional<Time> ended;          ///< within 10 ms; absent: it still ran at the end
  std::optional<HandResult> result;   ///< once it ended
  double width = 0;                   ///< between the fingers as it ended, m
  bool is_grasped = false;            ///< an object was held as it ended
  std::optional<VacuumState> pump{};  ///< of a cobot pump as it ended
  std::string failure;                ///< why the hand refused it; empty: it did not
};

/// Results of all commands to the hand of a run.
struct HandReport {
  std::vector<HandOutcome> commands;  ///< as the scenario lists them
  HandState state;                    ///< at the end of the run
};

/// Distance between two poses.
struct PoseError {
  double distance = 0;  ///< of the origins, m
  double angle = 0;     ///< of the turn between them, rad
};

/// Result of a motion.
struct MotionResult {
  std::string name;
  Time begun{};        ///< of the session
  Duration planned{};  ///< duration of the planned motion; the arm settles after it
  loop::RunReport report;
  JointVector goal{};      ///< last waypoint, or where the plan ends, rad
  double final_error = 0;  ///< largest distance of a joint from it at the end, rad
  /// Of a motion of poses, and of a controller that follows one: of the end effector, measured,
  /// from where the last waypoint has it.
  std::optional<PoseError> final_pose_error;
  CycleCounts counts;  ///< from its first cycle to where it was concluded; zero on remote robots
};

/// Result of a run, and of its motion. In lockstep every field but plan->wall repeats bit by bit
/// with the scenario.
/// The counts are of all cycles of the run.
struct RunResult : MotionResult {
  FollowedMotion followed;
  std::optional<record::FilterCounts> viability;  ///< of a scenario with tick.viability
  std::optional<HandReport> hand;                 ///< of a scenario with commands to it
  std::optional<BaseState> base;                  ///< at the end; of a robot on a mobile base
  std::optional<planning::PlanStatistics> plan;   ///< of a planned motion
  /// Fingerprint of all states INT sent, in order: the physics, without the log's format.
  std::uint64_t states_hash = 0;
};

/// The fingerprint of all states of a run, out of its log: RunResult::states_hash, unless the log
/// was cut short.
///
/// Threads: one thread. Real-time: no. @throws as record::LogReader.
[[nodiscard]] std::uint64_t StatesHashOf(const std::filesystem::path& log);

}  // namespace twin::run

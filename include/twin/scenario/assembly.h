#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/backend/registry.h"
#include "twin/control/registry.h"
#include "twin/core/base.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/loop/realtime_drive.h"
#include "twin/loop/run_report.h"
#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"
#include "twin/robot/robot_config.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/filter_counts.h"
#include "twin/rt/thread_setup.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/remote.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"

namespace twin::scenario {

/// What the program offers: filled from explicit lists by its main. Must outlive every run.
struct Catalogue {
  const backend::Registry& backends;
  const control::ControllerRegistry& controllers;
  const teleop::DeviceRegistry* devices = nullptr;  ///< of operators; null: there are none
};

/// Where a run gets its files from.
struct RunFiles {
  std::filesystem::path models;        ///< DataDirectory::models
  std::filesystem::path mesh_package;  ///< empty: primitive shapes
  std::filesystem::path cache;         ///< of compiled models; empty: none
  bool rebuild_cache = false;
};

/// What the run tells while it goes on; all may be empty. Called on the run's thread, outside the
/// tick.
struct RunHooks {
  /// About once per simulated 100 ms: the run's time, and the length of the planned motion.
  std::function<void(Time now, Duration planned)> progress;
  /// Changes worth a line: when, which kind, what.
  std::function<void(Time now, std::string_view kind, std::string_view text)> event;
  /// Set from a signal handler: the motion is stopped and the run ends. May be null.
  const volatile bool* interrupted = nullptr;
};

/// What became of the commands of a motion, as INT saw them.
struct CycleCounts {
  std::uint64_t served = 0;        ///< cycles with a command in time
  std::uint64_t held = 0;          ///< cycles without one
  std::uint64_t dropped = 0;       ///< commands that came late, doubled or with a wrong id
  std::uint64_t longest_loss = 0;  ///< most held cycles in a row

  [[nodiscard]] std::uint64_t cycles() const noexcept { return served + held; }
  /// Share of the cycles without a command, %; 0 of none.
  [[nodiscard]] double unserved_percent() const noexcept;

  /// One cycle more. Real-time: noexcept, allocates nothing.
  void Add(const rt::CycleRecord& record) noexcept TWIN_REALTIME;
};

/// What became of a command to the hand.
struct HandOutcome {
  std::optional<Time> begun;         ///< absent: the run was over before
  std::optional<Time> ended;         ///< seen to, within 10 ms; absent: it had not when the run was
  std::optional<HandResult> result;  ///< once it ended
  double width = 0;                  ///< between the fingers as it ended, m
  bool is_grasped = false;           ///< an object was held as it ended
  std::string failure;               ///< why it was refused, for people; empty: it was not
};

/// What the hand did in a run.
struct HandReport {
  std::vector<HandOutcome> commands;  ///< as the scenario lists them
  HandState state;                    ///< at the end of the run
};

/// How far a pose is from another.
struct PoseError {
  double distance = 0;  ///< of the origins, m
  double angle = 0;     ///< of the turn between them, rad
};

/// No way to the goal of a planned motion was found within its budget; there may be none. Exit code
/// 1.
class NoPlanError : public Error {
  using Error::Error;
};

/// What planning a run's motion took, and gave.
struct PlanReport {
  std::uint64_t checks = 0;   ///< of configurations for collision, by the search
  double found_length = 0;    ///< of the path as found, rad (Euclidean)
  double path_length = 0;     ///< and after shortening
  std::size_t waypoints = 0;  ///< of the trajectory
  Duration duration{};        ///< of the motion
};

/// What a run came to. Everything in it repeats with the scenario, bit by bit.
struct RunResult {
  loop::RunReport report;
  JointVector goal{};      ///< last waypoint, or where the plan ends, rad
  double final_error = 0;  ///< largest distance of a joint from it at the end, rad
  /// Of a motion of poses, and of a controller that follows one: of the end effector, measured,
  /// from where the last waypoint has it.
  std::optional<PoseError> final_pose_error;
  CycleCounts counts;
  FollowedMotion followed;
  std::optional<rt::FilterCounts> viability;  ///< of a scenario with tick.viability
  std::optional<HandReport> hand;             ///< of a scenario with commands to it
  std::optional<BaseState> base;              ///< at the end; of a robot on a mobile base
  std::optional<PlanReport> plan;             ///< of a planned motion
  /// Fingerprint of all states INT sent, in order: the physics, without the log's format.
  std::uint64_t states_hash = 0;
};

/// The robot's configuration that a scenario asks for.
/// @throws InputError when a field is out of range.
[[nodiscard]] robot::RobotConfig MakeRobotConfig(const Scenario& scenario, const RobotData& robot,
                                                 const RunFiles& files);

/// The same of a twin that is served, with the data of its robot: the wire itself delays and
/// reorders, so that of the link only the losses and d_INT are left.
/// @throws InputError also as LoadRobotData.
[[nodiscard]] robot::RobotConfig MakeServedConfig(const Scenario& scenario, const RunFiles& files);

/// The scenario's trajectory, checked against the robot's limits; of a motion of poses, the arm at
/// rest where it begins for as long as they take. @throws InputError as Trajectory and
/// PoseTrajectory, and for a motion that is planned: that takes a Run.
[[nodiscard]] reference::Trajectory MakeTrajectory(const Scenario& scenario,
                                                   const RobotData& robot);

/// The path of a motion of poses, checked against the robot's limits; nothing for others.
/// @throws InputError as PoseTrajectory.
[[nodiscard]] std::optional<reference::PoseTrajectory> MakePoses(const Scenario& scenario,
                                                                 const RobotData& robot);

/// Checks all of a scenario short of compiling the robot's model and running it: names, robot,
/// trajectory, start, tick, scene file. A motion that is to be planned is planned, on a model
/// compiled for that.
/// @throws InputError as Run does.
void Check(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files);

/// Drives realtime and remote: how the threads run, and which robot. Settings of the host, not of
/// the scenario.
struct RealtimeSettings {
  rt::ThreadSettings robot{.name = "twin-int", .fifo_priority = 98};
  loop::RealtimeThreads threads;
  RemoteSettings remote;
};

/// A scenario made ready to run: drive, connected backend, trajectory, controller.
///
/// Threads: one thread.
class Run {
 public:
  /// Builds and connects.
  /// @param sink  gets the records of cycles and ticks; may be null; must outlive the run. In
  /// lockstep all come from the calling thread; in real time cycles from the robot's thread and
  /// ticks from the communication's.
  /// @throws InputError for an unknown backend, controller or robot, a trajectory that breaks a
  /// limit, a plan whose start or goal touches something (which) or whose goal is out of reach, and
  /// what the backend's factory finds wrong; EnvironmentError and RobotFault from the latter;
  /// NoPlanError when no plan was found within its budget.
  Run(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
      rt::RecordSink* sink, const RealtimeSettings& settings = {});
  ~Run();
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  [[nodiscard]] const backend::Connection& connection() const noexcept;
  [[nodiscard]] const reference::Trajectory& trajectory() const noexcept;
  [[nodiscard]] const RobotData& robot() const noexcept;
  /// How long the planner took, on the wall clock; nothing when nothing was planned.
  [[nodiscard]] std::optional<Duration> planning_time() const noexcept;

  /// Drive remote, before Execute(): sends the robot the scenario's settings (section int) and
  /// looks whether it, the way to it and this host are ready for a motion. Nothing of it moves the
  /// arm. Takes about 0.5 s. @param tell  gets each line as soon as it is known.
  /// @returns whether all is well. @throws RobotFault when the connection is lost.
  [[nodiscard]] bool CheckStart(const TellCheck& tell);

  /// Runs the motion to its end. To be called once; on a remote robot only after CheckStart() found
  /// all well.
  /// @throws RobotFault when the motion is refused, InputError when it cannot start from where the
  /// robot is. A motion that starts and then fails is no exception: the report says how it ended.
  [[nodiscard]] RunResult Execute(const RunHooks& hooks = {});

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::scenario

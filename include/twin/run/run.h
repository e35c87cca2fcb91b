#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "twin/backend/registry.h"
#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/loop/drive.h"
#include "twin/planning/planner.h"
#include "twin/record/cycle_record.h"
#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"
#include "twin/rt/thread_setup.h"
#include "twin/run/catalogue.h"
#include "twin/run/remote.h"
#include "twin/run/result.h"
#include "twin/run/robot_config.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// Callbacks of a run; all may be empty. Called on the run's thread, outside the tick.
struct RunHooks {
  /// About once per 100 ms of the robot's time: the time, and the length of the planned motion.
  std::function<void(Time now, Duration planned)> progress;
  /// An event: time, kind, text.
  std::function<void(Time now, std::string_view kind, std::string_view text)> event;
  /// Whenever time has passed while a call waits, for a caller that looks for a reason to stop; it
  /// may set what `interrupted` points to.
  std::function<void()> look{};
  /// Set from a signal handler: the motion is stopped and the run ends. May be null.
  const volatile bool* interrupted = nullptr;
};

/// How the threads of real time run, and which robot. Of the host, not of the scenario.
struct RealtimeConfig {
  loop::DriveThreads threads;
  backend::RobotAddress remote;  ///< of the backend fci
  /// The checks before a remote robot's first motion must have found all well (CheckStart). False:
  /// a twin that this process serves itself, as the scenario has it.
  bool checks_start = true;
};

/// The planner found no path to the goal within its budget; there may be none. Exit code 1.
class NoPlanError : public Error {
  using Error::Error;
};

/// The scenario's trajectory, checked against the robot's limits; of a motion of poses, the arm at
/// rest where it begins for as long as they take. @throws InputError as Trajectory and
/// PoseTrajectory, and for a motion that is planned: that takes a Run.
[[nodiscard]] reference::Trajectory MakeTrajectory(const scenario::Scenario& scenario,
                                                   const scenario::RobotData& robot);

/// The path of a motion of poses, checked against the robot's limits; nullopt for others.
/// @throws InputError as PoseTrajectory.
[[nodiscard]] std::optional<reference::PoseTrajectory> MakePoses(const scenario::Scenario& scenario,
                                                                 const scenario::RobotData& robot);

/// Refuses a trajectory on which the arm would touch itself, the floor, the scene or an object, by
/// planning::CollisionWorld, every 2 ms; the hand is open, and what it carries stays where it was.
/// Not judged: motions with a reason to touch (motion.touches), planned ones, whose planner looks
/// itself, poses, of which the robot chooses the joints, and those of a base that drives.
/// @throws InputError naming time and parts; as MakeTrajectory.
void RequireFree(const scenario::Scenario& scenario, const RunFiles& files);

class PreparedMotion;
class Session;

/// A scenario made ready to run: a session with one motion, the scenario's.
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
  Run(const scenario::Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
      record::RecordSink* sink, const RealtimeConfig& settings = {});
  ~Run();
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  [[nodiscard]] const backend::Connection& connection() const noexcept;
  [[nodiscard]] const reference::Trajectory& trajectory() const noexcept;
  [[nodiscard]] const scenario::RobotData& robot() const noexcept;
  /// Profile::Excess of the motion; empty without a profile. Of a motion of poses it judges the
  /// load alone: what its joints do is known when it runs.
  [[nodiscard]] std::string ProfileExcess() const;
  /// Wall-clock time of the planner; nullopt without a planned motion.
  [[nodiscard]] std::optional<Duration> planning_time() const noexcept {
    return plan_ ? std::optional(plan_->wall) : std::nullopt;
  }

  /// With a remote robot, before Execute(): sends the robot the scenario's settings (section
  /// onboard) and looks whether it, the way to it and this host are ready for a motion. Nothing of
  /// it moves the arm. Takes about 0.5 s. @param tell  gets each line as soon as it is known.
  /// @returns whether all is well. @throws RobotFault when the connection is lost.
  [[nodiscard]] bool CheckStart(const TellCheck& tell);

  /// Runs the motion to its end. To be called once; on a remote robot only after CheckStart() found
  /// all well.
  /// @throws RobotFault when the motion is refused, InputError when it cannot start from where the
  /// robot is. A motion that starts and then fails is no exception: the report says how it ended.
  [[nodiscard]] RunResult Execute(const RunHooks& hooks = {});

 private:
  /// Plans anew when the robot stands a little beside robot.q_start. The checks before the motion
  /// refuse one that stands elsewhere.
  void PlanFromCurrentPosition(const Catalogue& catalogue, const RunFiles& files);

  const scenario::Scenario scenario_;
  std::optional<planning::PlanStatistics> plan_;  ///< of a planned motion
  std::unique_ptr<PreparedMotion> motion_;
  std::unique_ptr<Session> session_;
};

}  // namespace twin::run

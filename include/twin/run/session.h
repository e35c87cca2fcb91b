#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/backend/registry.h"
#include "twin/control/controller.h"
#include "twin/control/live_reference.h"
#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/core/robot_state.h"
#include "twin/core/time.h"
#include "twin/loop/loop_config.h"
#include "twin/loop/run_report.h"
#include "twin/record/cycle_record.h"
#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// One motion of a session: path, controller and tick.
struct Motion {
  std::string name;  ///< for messages: "approach"; empty: the run's only motion
  control::CommandInterface interface = control::CommandInterface::kJointPosition;
  /// INT's own controller, as MotionSection::controller.
  ControllerMode impedance = ControllerMode::kJointImpedance;
  /// Through joint space; of a motion of poses, the arm at rest at the start for their duration
  /// (StandingFor). It starts at the robot's position, within reference::kStartTolerance.
  reference::Trajectory trajectory;
  std::optional<reference::PoseTrajectory> poses{};
  scenario::ControllerSection controller{};
  /// Its generator goes with the interface, as in scenarios.
  scenario::TickSection tick{};
  loop::LoopKind loop = loop::LoopKind::kAsynchronous;
  /// Rate of a source that the controller only passes on (ControllerOutput::fresh), Hz; absent: the
  /// controller's.
  std::optional<double> source_rate_hz{};
  /// The operator's reference of the end effector; null: none. Must outlive the motion. The
  /// trajectory is then the arm at rest for the longest duration.
  control::LiveReference* live = nullptr;
  /// As loop::MotionRun's; may be empty.
  std::function<Time(Time now)> attend{};
};

/// The arm at rest for a duration. @throws InputError when `q` (rad) is not inside the limits or
/// the duration is not positive.
[[nodiscard]] reference::Trajectory StandingFor(const JointVector& q, Duration duration,
                                                const JointLimits& limits);

/// A motion on this interface with the scenario's loop, tick and controller timing. A generator
/// that does not fit the interface is replaced; the controller is the interface's default.
[[nodiscard]] Motion MotionOn(const scenario::Scenario& scenario, std::string name,
                              control::CommandInterface interface,
                              reference::Trajectory trajectory);

/// Result of a session.
struct SessionResult {
  std::uint64_t motions = 0;                      ///< number of motions that were run
  CycleCounts counts;                             ///< of all its cycles
  std::optional<record::FilterCounts> viability;  ///< of a scenario with tick.viability
  std::vector<FollowedMotion> followed;           ///< the motions that were run
  std::uint64_t states_hash = 0;                  ///< as RunResult
  backend::RobotTimings robot_timings;            ///< real time: of the simulated robot
  std::string unsound;                            ///< warnings of the simulation; empty: none
};

/// How a wait ended.
enum class WaitEnd : std::uint8_t {
  kDone,
  kTimeLimit,
  kInterrupted,
};

class CycleSummary;
class PreparedMotion;
struct RobotPlan;

/// A connected robot on any drive, on which motions and commands to the hand follow each other.
///
///     construct -> [CheckStart] -> Begin -> { Move | Command | Wait | Recover } ... -> End
///
/// Time continues from one to the next. In lockstep the virtual clock stands still between two
/// calls. In real time and on remote robots time passes by itself, also while the caller plans. All
/// records of all motions go to one sink, in order. Of a remote robot, states are recorded while a
/// motion runs.
///
/// The first motion gives the same bits as alone. Later ones draw their random numbers (target
/// noise, computation times) by seeds of their own, made of the scenario's seed and the motion's
/// number.
///
/// Threads: one thread; it may wait. Errors: any call throws RobotFault when the robot refuses, is
/// gone or does not answer; a motion that starts and then fails throws nothing, its report says so.
class Session {
 public:
  /// Connects. @param scenario  drive, backend, robot, plant, link, onboard, seed. Its motion and
  /// hand commands are not run. The arm rests at robot.q_start, else at the first waypoint; one of
  /// the two must be given.
  /// @param sink, settings  as Run's. @throws as Run's constructor.
  Session(const scenario::Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
          record::RecordSink* sink, const RealtimeConfig& settings = {});
  /// As above, with a robot that is resolved already.
  Session(const scenario::Scenario& scenario, RobotPlan robot, const Catalogue& catalogue,
          record::RecordSink* sink, const RealtimeConfig& settings);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  [[nodiscard]] const backend::Connection& connection() const noexcept {
    return drive_->connection();
  }
  [[nodiscard]] const scenario::RobotData& robot() const noexcept;

  /// The mobile base below the arm; null without one. Only the caller may command it.
  [[nodiscard]] backend::MobileBase* base() const noexcept { return connection().base; }

  /// As Run::CheckStart. @param first  the motion that will come first.
  [[nodiscard]] bool CheckStart(const Motion& first, const TellCheck& tell);

  /// q_d (rad) of a remote robot, before Begin(); nullopt when the robot is simulated or sends no
  /// state.
  [[nodiscard]] std::optional<JointVector> ReadCurrentPosition() const;

  /// Time begins, once. @param hooks  for all that follows; `planned` is the end of the motion
  /// under way. What they refer to must outlive the session.
  void Begin(const RunHooks& hooks = {});

  /// Runs a motion from start to end, and until the arm rests. @pre after Begin(), as all that
  /// follows. @throws InputError for an invalid motion, or one that cannot start at the robot's
  /// position; RobotFault when the robot refuses it (after a reflex: Recover() first).
  [[nodiscard]] MotionResult Move(const Motion& motion);
  /// As above, with a motion that was prepared before the session. @param attend  as
  /// Motion::attend.
  [[nodiscard]] MotionResult Move(PreparedMotion& motion, const std::function<Time(Time)>& attend);

  /// The scenario's own motion, planned if it says so, with its commands to hand and base, whose
  /// times count from the session's start. @param scenario  the session's, as it was given.
  /// @throws as Move(), and NoPlanError.
  [[nodiscard]] MotionResult MoveOwn(const scenario::Scenario& scenario, const RunFiles& files);

  /// Gives the hand a command and waits, in the robot's time, until it ends. Stops the command
  /// after `limit` and on an interrupt; the failure then says so. @throws InputError without a
  /// hand.
  [[nodiscard]] HandOutcome Command(const HandCommand& command,
                                    Duration limit = std::chrono::seconds(20));

  /// Lets the robot's time pass until `done` accepts a state.
  [[nodiscard]] WaitEnd Wait(Duration limit, const std::function<bool(const RobotState&)>& done);

  /// As Wait(), but asks `done` alone, after each event, and never looks for an interrupt.
  void PassUntil(const std::function<bool()>& done);

  /// Until no joint has been faster than 0.01 rad/s for 50 ms.
  [[nodiscard]] WaitEnd WaitForRest(Duration limit = std::chrono::seconds(5));

  /// The next state to come.
  [[nodiscard]] RobotState ReadState();

  /// Brings a robot that stopped by a reflex back to Idle: waits until the arm rests, requests
  /// automatic error recovery, waits for its end. Returns at once when the robot is Idle.
  /// @throws RobotFault when it is refused, or the robot is not Idle within 5 s, naming its mode.
  void Recover();

  /// Calls RunHooks::event with a text of the caller, at the robot's time.
  void Tell(std::string_view kind, std::string_view text) const {
    if (hooks_.event) hooks_.event(Now(), kind, text);
  }

  // Of a robot simulated in lockstep, between two motions; else InputError says so.

  /// The last state that INT sent; before the first cycle what it would send. No time passes.
  [[nodiscard]] RobotState Peek() const;
  /// Poses (X_WB) of the scene's free bodies in the world, by name; none on the ideal plant.
  [[nodiscard]] std::vector<std::pair<std::string, Transform>> Bodies() const;
  /// Puts a free body at rest. @throws InputError for an unknown name (which there are), a pose
  /// that is not rigid, and where it would lie deeper than plant::Plant::kMostOverlap in another.
  void Place(const std::string& body, const Transform& X_WB);
  /// Begins anew with the arm at rest at `q` (rad), as robot::Robot::Reset(); then lets the
  /// messages under way arrive. @throws InputError for a joint beyond its limits.
  void Reset(const JointVector& q);

  /// A copy of the whole twin, of the time, and of what has been counted. A few MB.
  class Snapshot;
  [[nodiscard]] std::unique_ptr<const Snapshot> Save() const;
  /// Goes back to a snapshot of this session: the same calls then give the same bits as after
  /// Save(), each time, counts and states_hash of End() included. Only the times of records and
  /// events go on rising. Before End() only.
  void Restore(const Snapshot& snapshot);

  [[nodiscard]] Time Now() const { return drive_->Now(); }
  [[nodiscard]] bool interrupted() const noexcept {
    return hooks_.interrupted != nullptr && *hooks_.interrupted;
  }

  /// Time ends: no record is put after it returns. A second call returns the same result.
  SessionResult End();

 private:
  [[nodiscard]] robot::Robot& LockstepRobot(std::string_view wish) const;
  /// Whether to stop waiting.
  [[nodiscard]] bool Look() const {
    if (hooks_.look) hooks_.look();
    return interrupted();
  }
  [[nodiscard]] std::uint64_t SeedOf(std::uint64_t motion) const noexcept;

  const scenario::Scenario scenario_;
  const std::unique_ptr<const RobotPlan> robot_;
  const RealtimeConfig settings_;
  const control::ControllerRegistry& controllers_;
  const std::unique_ptr<CycleSummary> summary_;  ///< passes the records on to the sink
  const std::unique_ptr<loop::Drive> drive_;
  RunHooks hooks_;
  bool begun_ = false;
  bool checked_ = false;       ///< CheckStart() of a remote robot found all well
  std::uint64_t motions_ = 0;  ///< begun
  std::vector<FollowedMotion> followed_;
  std::optional<SessionResult> result_;
};

class Session::Snapshot {
 public:
  ~Snapshot();

 private:
  friend class Session;
  struct Parts;
  explicit Snapshot(std::unique_ptr<const Parts> parts);

  std::unique_ptr<const Parts> parts_;
};

}  // namespace twin::run

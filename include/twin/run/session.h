#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
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
#include "twin/reference/pose_trajectory.h"
#include "twin/reference/trajectory.h"
#include "twin/rt/filter_counts.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"

namespace twin::run {

/// One motion of a session: what is followed, by which controller, through which tick.
struct Motion {
  std::string name;  ///< for people: "approach"; empty: it is the run's only one
  control::CommandInterface interface = control::CommandInterface::kJointPosition;
  /// INT's own controller, as MotionSection::controller.
  ControllerMode impedance = ControllerMode::kJointImpedance;
  /// Through joint space; of a motion of poses the arm at rest where it begins, for as long as they
  /// take (StandingFor). It starts where the robot is, within reference::kStartTolerance.
  reference::Trajectory trajectory;
  std::optional<reference::PoseTrajectory> poses{};
  scenario::ControllerSection controller{};
  /// Its generator goes with the interface, as in scenarios.
  scenario::TickSection tick{};
  loop::LoopKind loop = loop::LoopKind::kAsynchronous;
  /// Who leads the end effector; null: nobody. Must outlive the motion. The trajectory is then the
  /// arm at rest for as long as it may take.
  control::LiveReference* live = nullptr;
  /// As loop::MotionRun's; may be empty.
  std::function<Time(Time now)> attend{};
};

/// The arm at rest for a while. @throws InputError when `q` (rad) is not inside the limits or the
/// duration is not positive.
[[nodiscard]] reference::Trajectory StandingFor(const JointVector& q, Duration duration,
                                                const JointLimits& limits);

/// A motion on this interface with the scenario's loop, tick and controller's timing; its generator
/// is the interface's unless the scenario wants none, its controller the interface's default.
[[nodiscard]] Motion MotionOn(const scenario::Scenario& scenario, std::string name,
                              control::CommandInterface interface,
                              reference::Trajectory trajectory);

/// What a motion came to.
struct MotionResult {
  std::string name;
  Time begun{};  ///< of the session
  loop::RunReport report;
  JointVector goal{};                         ///< last point of the trajectory, rad
  double final_error = 0;                     ///< as RunResult
  std::optional<PoseError> final_pose_error;  ///< as RunResult
  CycleCounts counts;  ///< from its first cycle to where it was concluded; zero on remote robots
};

/// What a session came to.
struct SessionResult {
  std::uint64_t motions = 0;                  ///< that were run
  CycleCounts counts;                         ///< of all its cycles
  std::optional<rt::FilterCounts> viability;  ///< of a scenario with tick.viability
  std::vector<FollowedMotion> followed;       ///< the motions that were run
  std::uint64_t states_hash = 0;              ///< as RunResult
  backend::RobotTimings robot_timings;        ///< real time: of the simulated robot
  std::string unsound;                        ///< what the simulation complained of; empty: nothing
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
/// Time goes on from one to the next: in lockstep on the one virtual clock, which stands still
/// between two calls; in real time and on remote robots by itself, so whatever the caller does in
/// between (planning) passes for the arm, at rest. All records of all motions go to one sink, in
/// order. Of a remote robot, states are recorded while a motion runs.
///
/// The first motion is what it is alone, bit by bit. Random numbers of later ones (target noise,
/// computation times) are drawn by seeds of their own, made of the scenario's and the motion's
/// number.
///
/// Threads: one thread; it may wait. Errors: a robot that refuses, is gone or does not answer is a
/// RobotFault from any call; a motion that starts and then fails is none: its report says so.
class Session {
 public:
  /// Connects. @param scenario  drive, backend, robot, plant, link, onboard, seed. Its motion is
  /// not run, only robot.q_start (else its first waypoint) says where the arm rests; a scenario
  /// without waypoints must have the former. Its hand script is not run either.
  /// @param sink, settings  as Run's. @throws as Run's constructor.
  Session(const scenario::Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
          rt::RecordSink* sink, const RealtimeSettings& settings = {});
  /// The same of a robot that is resolved already.
  Session(const scenario::Scenario& scenario, RobotPlan robot, const Catalogue& catalogue,
          rt::RecordSink* sink, const RealtimeSettings& settings);
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

  /// Where a robot at the other end of a wire holds itself (q_d, rad), before Begin(). Nothing: it
  /// is simulated, or no state came.
  [[nodiscard]] std::optional<JointVector> ReadCurrentPosition() const;

  /// Time begins, once. @param hooks  for all that follows; the plan that progress is told is the
  /// end of the motion under way. What they refer to must outlive the session.
  void Begin(const RunHooks& hooks = {});

  /// Runs a motion from start to end, and until the arm rests. @pre after Begin(), as all that
  /// follows. @throws InputError when it is not well formed or cannot start from where the robot
  /// is; RobotFault when it is refused (after a reflex: Recover() first).
  [[nodiscard]] MotionResult Move(const Motion& motion);
  /// The same of a motion that was prepared before the session. @param attend  as Motion::attend.
  [[nodiscard]] MotionResult Move(PreparedMotion& motion, const std::function<Time(Time)>& attend);

  /// Gives the hand a command and waits, in the robot's time, until it has ended. One that has not
  /// within `limit`, or when the session is interrupted, is stopped; the failure then says so.
  /// @throws InputError when there is no hand.
  [[nodiscard]] HandOutcome Command(const HandCommand& command,
                                    Duration limit = std::chrono::seconds(20));

  /// Lets the robot's time pass until `done` says so of a state that came.
  [[nodiscard]] WaitEnd Wait(Duration limit, const std::function<bool(const RobotState&)>& done);

  /// Until no joint has been faster than 0.01 rad/s for 50 ms.
  [[nodiscard]] WaitEnd WaitForRest(Duration limit = std::chrono::seconds(5));

  /// The next state to come.
  [[nodiscard]] RobotState ReadState();

  /// Brings a robot that stopped by a reflex back to Idle: waits until the arm rests, asks for
  /// automatic error recovery, waits until it is done. Idle already: nothing happens.
  /// @throws RobotFault when it is refused, or the robot is not Idle within 5 s, naming its mode.
  void Recover();

  /// Tells RunHooks::event something of the caller's, at the robot's time.
  void Tell(std::string_view kind, std::string_view text) const {
    if (hooks_.event) hooks_.event(Now(), kind, text);
  }

  [[nodiscard]] Time Now() const { return drive_->Now(); }
  [[nodiscard]] bool interrupted() const noexcept {
    return hooks_.interrupted != nullptr && *hooks_.interrupted;
  }

  /// Time ends: no record is put after it returns. More than once: the same again.
  SessionResult End();

 private:
  [[nodiscard]] std::uint64_t SeedOf(std::uint64_t motion) const noexcept;

  const scenario::Scenario scenario_;
  const std::unique_ptr<const RobotPlan> robot_;
  const RealtimeSettings settings_;
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

}  // namespace twin::run

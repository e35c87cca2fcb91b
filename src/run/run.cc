#include "twin/run/run.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "run/drive_script.h"
#include "run/hand_script.h"
#include "run/prepared_motion.h"
#include "run/resolve.h"
#include "run/start_check.h"
#include "twin/run/session.h"

namespace twin::run {
namespace {

/// The scenario's own motion.
Motion MotionOf(const scenario::Scenario& scenario, const reference::Trajectory& trajectory,
                std::optional<reference::PoseTrajectory> poses) {
  return {.name = {},
          .interface = scenario.motion.interface,
          .impedance = scenario.motion.controller,
          .trajectory = trajectory,
          .poses = std::move(poses),
          .controller = scenario.controller,
          .tick = scenario.tick,
          .loop = scenario.loop};
}

/// Whether a motion may be planned from `q` instead of from `q_start`.
bool IsNear(const JointVector& q, const JointVector& q_start) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!(std::abs(q[i] - q_start[i]) <= kPlanStartTolerance)) return false;
  }
  return true;
}

/// Ends a session whatever happens: no record is put after the run is over.
class EndGuard {
 public:
  explicit EndGuard(Session& session) noexcept : session_(session) {}
  ~EndGuard() { static_cast<void>(session_.End()); }
  EndGuard(const EndGuard&) = delete;
  EndGuard& operator=(const EndGuard&) = delete;

 private:
  Session& session_;
};

}  // namespace

/// A session with one motion, the scenario's.
class Run::Impl {
 public:
  Impl(const scenario::Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
       rt::RecordSink* sink, const RealtimeSettings& settings)
      : Impl(scenario, MakePlan(scenario, catalogue, files), catalogue, sink, settings) {
    if (planning_) PlanFromCurrentPosition(catalogue, files);
  }

  RunResult Execute(const RunHooks& hooks);
  [[nodiscard]] bool CheckStart(const TellCheck& tell) {
    return session_.CheckStart(motion_->motion(), tell);
  }
  [[nodiscard]] const reference::Trajectory& trajectory() const noexcept {
    return motion_->motion().trajectory;
  }
  [[nodiscard]] const Session& session() const noexcept { return session_; }
  [[nodiscard]] std::optional<Duration> planning_time() const noexcept {
    if (!planning_) return std::nullopt;
    return planning_->wall;
  }

 private:
  // The motion is prepared before the robot is connected: what is wrong with it is known then.
  Impl(const scenario::Scenario& scenario, Plan plan, const Catalogue& catalogue,
       rt::RecordSink* sink, const RealtimeSettings& settings)
      : scenario_(scenario),
        planning_(plan.planning),
        motion_(std::in_place, scenario, plan.robot,
                MotionOf(scenario, plan.trajectory, plan.poses), catalogue.controllers),
        session_(scenario, {std::move(plan.robot), std::move(plan.config)}, catalogue, sink,
                 settings) {}

  /// Plans anew when the robot stands a little beside robot.q_start. One that stands elsewhere is
  /// left to the checks before the motion, which refuse it.
  void PlanFromCurrentPosition(const Catalogue& catalogue, const RunFiles& files);

  /// Nothing when the scenario has no commands to the hand.
  [[nodiscard]] std::optional<HandScript> MakeHandScript(const RunHooks& hooks) const;

  /// Nothing when the scenario asks nothing of a base.
  [[nodiscard]] std::optional<DriveScript> MakeDriveScript(const RunHooks& hooks) const;

  const scenario::Scenario scenario_;
  std::optional<planning::PlanStatistics> planning_;  ///< of a planned motion
  std::optional<PreparedMotion> motion_;              ///< always there
  Session session_;
};

void Run::Impl::PlanFromCurrentPosition(const Catalogue& catalogue, const RunFiles& files) {
  const std::optional<JointVector> q = session_.ReadCurrentPosition();
  if (!q || *q == trajectory().start() || !IsNear(*q, trajectory().start())) return;
  const reference::Trajectory planned =
      PlanFrom(*q, scenario_, session_.robot(), files, planning_.emplace());
  motion_.emplace(scenario_, session_.robot(), MotionOf(scenario_, planned, std::nullopt),
                  catalogue.controllers);
}

std::optional<HandScript> Run::Impl::MakeHandScript(const RunHooks& hooks) const {
  if (scenario_.hand.empty()) return std::nullopt;
  HandScript::Tell tell;
  if (hooks.event) {
    tell = [&hooks](Time now, std::string_view text) { hooks.event(now, "hand", text); };
  }
  return HandScript(scenario_.hand, RequireHand(session_.connection(), scenario_.backend), tell);
}

std::optional<DriveScript> Run::Impl::MakeDriveScript(const RunHooks& hooks) const {
  if (!scenario_.base || scenario_.base->drive.empty()) return std::nullopt;
  DriveScript::Tell tell;
  if (hooks.event) {
    tell = [&hooks](Time now, std::string_view text) { hooks.event(now, "base", text); };
  }
  return DriveScript(scenario_.base->drive, RequireBase(session_.connection(), scenario_.backend),
                     tell);
}

RunResult Run::Impl::Execute(const RunHooks& hooks) {
  std::optional<HandScript> hand = MakeHandScript(hooks);
  std::optional<DriveScript> drive = MakeDriveScript(hooks);
  std::function<Time(Time)> attend;
  if (hand || drive) {
    attend = [&hand, &drive](Time now) {
      const Time next = hand ? hand->Attend(now) : Time::max();
      return drive ? std::min(next, drive->Attend(now)) : next;
    };
  }
  session_.Begin(hooks);
  const EndGuard end_guard(session_);
  MotionResult motion = session_.Move(*motion_, attend);
  RunResult result;
  if (hand) result.hand = hand->Report();
  if (const backend::MobileBase* base = session_.base()) result.base = base->ReadState();
  const SessionResult session = session_.End();
  result.report = std::move(motion.report);
  result.report.robot_timings = session.robot_timings;
  if (!session.unsound.empty()) {
    result.report.failure = "the simulation itself became unsound: " + session.unsound;
  }
  result.goal = motion.goal;
  result.final_error = motion.final_error;
  result.final_pose_error = motion.final_pose_error;
  result.counts = session.counts;
  result.followed = session.followed.front();
  result.followed.succeeded = result.report.succeeded();
  result.viability = session.viability;
  result.states_hash = session.states_hash;
  if (planning_) {
    result.plan = PlanReport{.checks = planning_->checks,
                             .found_length = planning_->found_length,
                             .path_length = planning_->path_length,
                             .waypoints = planning_->waypoints,
                             .duration = trajectory().duration()};
  }
  return result;
}

Run::Run(const scenario::Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
         rt::RecordSink* sink, const RealtimeSettings& settings) {
  impl_ = std::make_unique<Impl>(scenario, catalogue, files, sink, settings);
}

Run::~Run() = default;

const backend::Connection& Run::connection() const noexcept {
  return impl_->session().connection();
}

const reference::Trajectory& Run::trajectory() const noexcept {
  return impl_->trajectory();
}

const scenario::RobotData& Run::robot() const noexcept {
  return impl_->session().robot();
}

std::optional<Duration> Run::planning_time() const noexcept {
  return impl_->planning_time();
}

bool Run::CheckStart(const TellCheck& tell) {
  return impl_->CheckStart(tell);
}

RunResult Run::Execute(const RunHooks& hooks) {
  return impl_->Execute(hooks);
}

}  // namespace twin::run

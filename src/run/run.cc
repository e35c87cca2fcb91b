#include "twin/run/run.h"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "run/prepared_motion.h"
#include "run/resolve.h"
#include "run/scripts.h"
#include "run/start_check.h"
#include "twin/run/session.h"

namespace twin::run {
namespace {

/// Whether a motion may be planned from `q` instead of from `q_start`.
bool IsNear(const JointVector& q, const JointVector& q_start) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!(std::abs(q[i] - q_start[i]) <= kPlanStartTolerance)) return false;
  }
  return true;
}

}  // namespace

Run::Run(const scenario::Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
         record::RecordSink* sink, const RealtimeConfig& settings)
    : scenario_(scenario) {
  Plan plan = MakePlan(scenario, catalogue, files);
  plan_ = plan.planning;
  // Before the robot is connected: what is wrong with the motion is known then.
  motion_ = std::make_unique<PreparedMotion>(scenario, plan.robot, std::move(plan.motion),
                                             catalogue.controllers);
  session_ =
      std::make_unique<Session>(scenario, RobotPlan{std::move(plan.robot), std::move(plan.config)},
                                catalogue, sink, settings);
  if (plan_) PlanFromCurrentPosition(catalogue, files);
}

Run::~Run() = default;

void Run::PlanFromCurrentPosition(const Catalogue& catalogue, const RunFiles& files) {
  const std::optional<JointVector> q = session_->ReadCurrentPosition();
  if (!q || *q == trajectory().start() || !IsNear(*q, trajectory().start())) return;
  motion_ = std::make_unique<PreparedMotion>(
      scenario_, robot(),
      MotionOf(scenario_, robot(), PlanMotion(scenario_, robot(), *q, files, *plan_)),
      catalogue.controllers);
}

const backend::Connection& Run::connection() const noexcept {
  return session_->connection();
}

const reference::Trajectory& Run::trajectory() const noexcept {
  return motion_->motion().trajectory;
}

std::string Run::ProfileExcess() const {
  const auto& profile = scenario_.places.profile;
  if (!profile) return {};
  JointVector speed = trajectory().peaks().velocity;
  for (std::size_t i = 0; i < kJoints; ++i) speed[i] *= robot().limits.dq_max[i];
  return profile->Excess(speed, scenario_.robot.load.m_load);
}

const scenario::RobotData& Run::robot() const noexcept {
  return session_->robot();
}

bool Run::CheckStart(const TellCheck& tell) {
  return session_->CheckStart(motion_->motion(), tell);
}

RunResult Run::Execute(const RunHooks& hooks) {
  MotionScripts scripts(scenario_, connection(), hooks);
  session_->Begin(hooks);
  // No record is put after the run, even if it throws.
  const auto end = [](Session* session) { static_cast<void>(session->End()); };
  const std::unique_ptr<Session, decltype(end)> end_guard(session_.get(), end);
  RunResult result;
  static_cast<MotionResult&>(result) = session_->Move(*motion_, scripts.Attend());
  result.hand = scripts.Report();
  if (const backend::MobileBase* base = session_->base()) result.base = base->ReadState();
  const SessionResult session = session_->End();
  result.report.robot_timings = session.robot_timings;
  if (!session.unsound.empty()) {
    result.report.failure = "the simulation itself became unsound: " + session.unsound;
  }
  result.counts = session.counts;
  result.followed = session.followed.front();
  result.followed.succeeded = result.report.succeeded();
  result.viability = session.viability;
  result.states_hash = session.states_hash;
  result.plan = plan_;
  return result;
}

}  // namespace twin::run

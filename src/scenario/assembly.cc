#include "twin/scenario/assembly.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "scenario/cycle_summary.h"
#include "scenario/hand_script.h"
#include "scenario/plan.h"
#include "scenario/start_check.h"
#include "twin/core/error.h"
#include "twin/core/half_norm.h"
#include "twin/loop/lockstep_drive.h"
#include "twin/loop/realtime_drive.h"
#include "twin/loop/state_time_drive.h"
#include "twin/model/arm_model.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/model/transform.h"
#include "twin/rt/event_queue.h"

namespace twin::scenario {
namespace {

/// What a run may take beyond the planned motion: settling behind the reference generator (time
/// constant 1 s at lambda = 1e-3, so 10 s are 5e-5 of what was left) and connecting.
constexpr Duration kBeyondPlan = std::chrono::seconds(20);

double LargestDistance(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// @param onboard  says where the end effector is.
PoseError PoseErrorOf(const JointVector& q, const JointVector& goal,
                      const onboard::IntConfig& onboard) {
  const Transform F_T_EE = model::Multiply(onboard.F_T_NE, onboard.end_effector_frame.NE_T_EE);
  const auto pose = [&F_T_EE](const JointVector& at) {
    return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, at, F_T_EE);
  };
  const Vector6 way = model::Displacement(pose(q), pose(goal));
  return {.distance = HalfNorm(way, 0), .angle = HalfNorm(way, 3)};
}

/// What stands behind a motion: the connected backend on its drive's time.
class Setting {
 public:
  virtual ~Setting() = default;
  [[nodiscard]] virtual const backend::Connection& connection() const noexcept = 0;
  /// As scenario::Run::CheckStart; of a simulated robot there is nothing to check.
  [[nodiscard]] virtual bool Check(const Scenario& /*scenario*/, const Plan& /*plan*/,
                                   const TellCheck& /*tell*/) {
    return true;
  }
  [[nodiscard]] virtual loop::RunReport Run(const loop::MotionRun& run) = 0;
};

class LockstepSetting final : public Setting {
 public:
  LockstepSetting(const backend::Factory& connect, const robot::RobotConfig& robot,
                  rt::RecordSink* sink)
      : connection_(connect({robot, backend::LockstepHost{events_, drive_.StateReady()}, sink})) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] loop::RunReport Run(const loop::MotionRun& run) override {
    return drive_.Run(events_, run);
  }

 private:
  // The backend's robot is on the queue and tells the drive: it must go first.
  rt::EventQueue events_;
  loop::LockstepDrive drive_;
  backend::Connection connection_;
};

class RealtimeSetting final : public Setting {
 public:
  RealtimeSetting(const backend::Factory& connect, const robot::RobotConfig& robot,
                  rt::RecordSink* sink, const RealtimeSettings& settings)
      : threads_(settings.threads),
        connection_(connect({robot, backend::RealtimeHost{clock_, settings.robot}, sink})) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] loop::RunReport Run(const loop::MotionRun& run) override {
    clock_.Restart();
    return loop::RunInRealtime(clock_, connection_, run, threads_);
  }

 private:
  MonotonicClock clock_;
  loop::RealtimeThreads threads_;
  backend::Connection connection_;
};

class RemoteSetting final : public Setting {
 public:
  RemoteSetting(const backend::Factory& connect, const robot::RobotConfig& robot,
                rt::RecordSink* sink, const RealtimeSettings& settings)
      : settings_(settings),
        connection_(connect({robot,
                             backend::RemoteHost{.clock = clock_,
                                                 .address = settings.remote.host,
                                                 .arm_port = settings.remote.arm_port,
                                                 .time = settings.remote.time,
                                                 .capture = settings.remote.capture},
                             sink})) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] bool Check(const Scenario& scenario, const Plan& plan,
                           const TellCheck& tell) override {
    StartCheck check{.clock = clock_,
                     .backend = *connection_.backend,
                     .arrival = *connection_.arrival,
                     .time = settings_.remote.time,
                     .listening = {}};
    check.listening.thread = settings_.threads.communication;
    if (plan.tick.period_tolerance > Duration::zero()) {
      check.listening.tolerance = plan.tick.period_tolerance;
    }
    checked_ = RunStartCheck(check, scenario, plan.robot, plan.trajectory.start(), tell);
    return checked_;
  }
  [[nodiscard]] loop::RunReport Run(const loop::MotionRun& run) override {
    if (!checked_) {
      throw RobotFault("the robot is not moved: not all checks before its first motion are well");
    }
    loop::MotionRun remote = run;
    remote.record_states = true;
    clock_.Restart();
    loop::RunReport report =
        settings_.remote.time == backend::RobotTime::kStates
            ? loop::RunOnStateTime(clock_, connection_, remote)
            : loop::RunInRealtime(clock_, connection_, remote, settings_.threads);
    const std::string why = connection_.why_lost ? connection_.why_lost() : "";
    if (!why.empty() && !report.failure.empty()) report.failure += "; " + why;
    return report;
  }

 private:
  MonotonicClock clock_;
  const RealtimeSettings settings_;
  backend::Connection connection_;
  bool checked_ = false;
};

std::unique_ptr<Setting> MakeSetting(const Scenario& scenario, const backend::Factory& connect,
                                     const robot::RobotConfig& robot, rt::RecordSink* sink,
                                     const RealtimeSettings& settings) {
  if (scenario.drive == Drive::kRealtime) {
    return std::make_unique<RealtimeSetting>(connect, robot, sink, settings);
  }
  if (scenario.drive == Drive::kRemote) {
    return std::make_unique<RemoteSetting>(connect, robot, sink, settings);
  }
  return std::make_unique<LockstepSetting>(connect, robot, sink);
}

}  // namespace

class Run::Impl {
 public:
  Impl(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
       rt::RecordSink* sink, const RealtimeSettings& settings)
      : scenario_(scenario),
        plan_(MakePlan(scenario, catalogue, files)),
        controller_(catalogue.controllers.Find(scenario.controller.type)(
            {plan_.trajectory, scenario.motion.interface})),
        summary_(sink),
        setting_(MakeSetting(scenario, catalogue.backends.Find(scenario.backend), plan_.config,
                             &summary_, settings)) {}

  RunResult Execute(const RunHooks& hooks);
  /// What a motion is, without what watches it.
  [[nodiscard]] loop::MotionRun MakeMotion(const RunHooks& hooks);
  /// Nothing when the scenario has no commands to the hand.
  [[nodiscard]] std::optional<HandScript> MakeHandScript(const RunHooks& hooks) const;

  const Scenario scenario_;
  const Plan plan_;
  std::unique_ptr<control::Controller> controller_;
  CycleSummary summary_;
  std::unique_ptr<Setting> setting_;
};

loop::MotionRun Run::Impl::MakeMotion(const RunHooks& hooks) {
  const Duration planned = plan_.trajectory.duration();
  loop::MotionRun run{.backend = *setting_->connection().backend,
                      .controller = *controller_,
                      .modes = plan_.modes,
                      .kind = plan_.loop,
                      .tick = plan_.tick,
                      .controller_loop = plan_.controller_loop,
                      .seed = scenario_.seed,
                      .time_limit = planned + kBeyondPlan,
                      .sink = &summary_,
                      .progress = {},
                      .event = hooks.event,
                      .interrupted = hooks.interrupted};
  if (hooks.progress) run.progress = [&hooks, planned](Time now) { hooks.progress(now, planned); };
  return run;
}

std::optional<HandScript> Run::Impl::MakeHandScript(const RunHooks& hooks) const {
  if (scenario_.hand.empty()) return std::nullopt;
  backend::Hand* hand = setting_->connection().hand;
  if (hand == nullptr) {
    throw InputError(
        fmt::format("hand: the backend {} has no hand; leave the commands out", scenario_.backend));
  }
  HandScript::Tell tell;
  if (hooks.event) {
    tell = [&hooks](Time now, std::string_view text) { hooks.event(now, "hand", text); };
  }
  return HandScript(scenario_.hand, *hand, tell);
}

RunResult Run::Impl::Execute(const RunHooks& hooks) {
  const backend::Connection& connection = setting_->connection();
  loop::MotionRun run = MakeMotion(hooks);
  std::optional<HandScript> hand = MakeHandScript(hooks);
  if (hand) run.attend = [&hand](Time now) { return hand->Attend(now); };
  RunResult result;
  result.report = setting_->Run(run);
  if (hand) result.hand = hand->Report();
  for (const rt::TickRecord& tick : result.report.evidence) {
    if (hooks.event) hooks.event(tick.read, "evidence", loop::DescribeTick(tick));
  }
  result.goal = plan_.trajectory.goal();
  result.final_error = LargestDistance(result.report.q_final, result.goal);
  if (scenario_.motion.interface == control::CommandInterface::kCartesianPose) {
    result.final_pose_error = PoseErrorOf(result.report.q_final, result.goal, plan_.config.onboard);
  }
  result.counts = summary_.counts();
  result.states_hash = summary_.states_hash();
  const std::string warnings = connection.engine_warnings ? connection.engine_warnings() : "";
  if (!warnings.empty()) {
    result.report.failure = "the simulation itself became unsound: " + warnings;
  }
  return result;
}

Run::Run(const Scenario& scenario, const Catalogue& catalogue, const RunFiles& files,
         rt::RecordSink* sink, const RealtimeSettings& settings) {
  impl_ = std::make_unique<Impl>(scenario, catalogue, files, sink, settings);
}

Run::~Run() = default;

const backend::Connection& Run::connection() const noexcept {
  return impl_->setting_->connection();
}

const reference::Trajectory& Run::trajectory() const noexcept {
  return impl_->plan_.trajectory;
}

const RobotData& Run::robot() const noexcept {
  return impl_->plan_.robot;
}

bool Run::CheckStart(const TellCheck& tell) {
  return impl_->setting_->Check(impl_->scenario_, impl_->plan_, tell);
}

RunResult Run::Execute(const RunHooks& hooks) {
  return impl_->Execute(hooks);
}

}  // namespace twin::scenario

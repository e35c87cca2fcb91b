#include "twin/scenario/assembly.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "scenario/cycle_summary.h"
#include "scenario/plan.h"
#include "twin/loop/lockstep_drive.h"
#include "twin/loop/realtime_drive.h"
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

/// What stands behind a motion: the connected backend on its drive's time.
class Setting {
 public:
  virtual ~Setting() = default;
  [[nodiscard]] virtual const backend::Connection& connection() const noexcept = 0;
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

std::unique_ptr<Setting> MakeSetting(const Scenario& scenario, const backend::Factory& connect,
                                     const robot::RobotConfig& robot, rt::RecordSink* sink,
                                     const RealtimeSettings& settings) {
  if (scenario.drive == Drive::kRealtime) {
    return std::make_unique<RealtimeSetting>(connect, robot, sink, settings);
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

  const Scenario scenario_;
  const Plan plan_;
  std::unique_ptr<control::Controller> controller_;
  CycleSummary summary_;
  std::unique_ptr<Setting> setting_;
};

RunResult Run::Impl::Execute(const RunHooks& hooks) {
  const Duration planned = plan_.trajectory.duration();
  const backend::Connection& connection = setting_->connection();
  loop::MotionRun run{.backend = *connection.backend,
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
  if (hooks.progress) run.progress = [&](Time now) { hooks.progress(now, planned); };
  RunResult result;
  result.report = setting_->Run(run);
  for (const rt::TickRecord& tick : result.report.evidence) {
    if (hooks.event) hooks.event(tick.read, "evidence", loop::DescribeTick(tick));
  }
  result.goal = plan_.trajectory.goal();
  result.final_error = LargestDistance(result.report.q_final, result.goal);
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

RunResult Run::Execute(const RunHooks& hooks) {
  return impl_->Execute(hooks);
}

}  // namespace twin::scenario

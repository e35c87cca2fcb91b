#include "twin/loop/state_time_drive.h"

#include "loop/motion_session.h"
#include "twin/core/check.h"
#include "twin/core/error.h"
#include "twin/loop/control_tick.h"
#include "twin/loop/controller_loop.h"
#include "twin/loop/exchange.h"
#include "twin/loop/state_time_loop.h"

namespace twin::loop {
namespace {

/// Longest wait for a state without a look at what the caller wants.
constexpr Duration kLook = std::chrono::milliseconds(50);

/// What costs and tolerances mean on a clock has no meaning on states.
MotionRun OnStates(const MotionRun& run) {
  if (run.kind == LoopKind::kSynchronous) {
    throw InputError(
        "loop: synchronous sleeps on a clock of its own, and a robot whose time is its states has "
        "none to sleep by; say --robot-time wall, or loop: asynchronous");
  }
  MotionRun on_states = WithoutModels(run);
  on_states.tick.period_tolerance = Duration::zero();
  return on_states;
}

class StateTimeStage final : public Stage {
 public:
  StateTimeStage(const MonotonicClock& clock, rt::Arrival& arrival, const MotionRun& run,
                 StateTimeline& timeline)
      : clock_(clock),
        arrival_(arrival),
        run_(run),
        timeline_(timeline),
        tick_(run.tick, run.controller.command_interface(), exchange_),
        controller_(run.controller_loop, run.controller, exchange_, run.seed),
        loop_(tick_, run.backend, run.sink, controller_, timeline.first_id, timeline.now) {
    loop_.RecordStates(run.record_states);
  }
  ~StateTimeStage() override { timeline_ = {loop_.first_id(), loop_.now()}; }
  StateTimeStage(const StateTimeStage&) = delete;
  StateTimeStage& operator=(const StateTimeStage&) = delete;

  RunReport Run() {
    static_cast<void>(loop_.Start(Now()));
    RunReport report = MotionSession(run_, *this, watch_).Run();
    report.timings = loop_.timings();
    report.deviation = loop_.deviation();
    report.controller_overruns = controller_.overruns();
    if (watch_.failure() != LoopFailure::kNone) report.evidence = loop_.LastTicks();
    return report;
  }

  [[nodiscard]] Time Now() const override { return loop_.now(); }
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool()>& done) override {
    while (!done()) {
      if (Now() >= limit || lost_) return false;
      Step();
    }
    return true;
  }
  [[nodiscard]] const RobotState& State() override { return loop_.state(); }
  void Activate(const MotionModes& modes) override { loop_.Activate(modes); }
  void StopController() override { loop_.StopController(); }

 private:
  /// One state, if one comes in time.
  void Step() {
    switch (loop_.OnState()) {
      case CommunicationLoop::Outcome::kPending:
        static_cast<void>(arrival_.AwaitUntil(clock_.Now() + kLook));
        return;
      case CommunicationLoop::Outcome::kLost:
        lost_ = true;
        watch_.Fail(LoopFailure::kConnectionLost);
        return;
      case CommunicationLoop::Outcome::kComputing: break;
    }
    loop_.Write();
    static_cast<void>(loop_.OnDone(Now()));
    static_cast<void>(watch_.Observe(loop_.InMotion(), Now()));
    if (loop_.record().action == rt::TickAction::kInvalid) {
      watch_.Fail(LoopFailure::kInvalidCommand);
    }
  }

  const MonotonicClock& clock_;
  rt::Arrival& arrival_;
  const MotionRun& run_;
  StateTimeline& timeline_;
  Exchange exchange_;
  MotionWatch watch_;
  ControlTick tick_;
  ControllerLoop controller_;
  StateTimeLoop loop_;
  bool lost_ = false;
};

}  // namespace

RunReport RunOnStateTime(const MonotonicClock& clock, const backend::Connection& connection,
                         const MotionRun& run, StateTimeline* timeline) {
  TWIN_CHECK(connection.arrival != nullptr);
  const MotionRun on_states = OnStates(run);
  StateTimeline own;
  return StateTimeStage(clock, *connection.arrival, on_states,
                        timeline == nullptr ? own : *timeline)
      .Run();
}

}  // namespace twin::loop

#include "twin/loop/realtime_drive.h"

#include <algorithm>
#include <optional>

#include "loop/communication_thread.h"
#include "loop/controller_thread.h"
#include "loop/motion_session.h"
#include "twin/core/check.h"
#include "twin/core/error.h"
#include "twin/loop/control_tick.h"
#include "twin/loop/controller_loop.h"
#include "twin/loop/exchange.h"
#include "twin/rt/sleep.h"

namespace twin::loop {
namespace {

/// How often the onlooker looks.
constexpr Duration kLook = std::chrono::milliseconds(5);

/// What both threads were refused is told once.
void AddNew(const std::vector<std::string>& notices, std::vector<std::string>& all) {
  for (const std::string& notice : notices) {
    if (std::ranges::find(all, notice) == all.end()) all.push_back(notice);
  }
}

class RealtimeStage final : public Stage {
 public:
  RealtimeStage(const MonotonicClock& clock, const backend::Connection& connection,
                const MotionRun& run, const RealtimeThreads& threads)
      : clock_(clock),
        run_(run),
        moving_(clock),
        tick_(run.tick, run.controller.command_interface(), exchange_),
        loop_(MakeLoop(run, tick_, exchange_)),
        controller_loop_(run.controller_loop, run.controller, exchange_, run.seed),
        communication_(clock, *loop_, run.backend, *connection.arrival, watch_, moving_,
                       threads.communication) {
    if (run.kind == LoopKind::kAsynchronous) {
      controller_.emplace(clock, controller_loop_, watch_, moving_, threads.controller);
    }
  }
  ~RealtimeStage() override { End(); }
  RealtimeStage(const RealtimeStage&) = delete;
  RealtimeStage& operator=(const RealtimeStage&) = delete;

  RunReport Run() {
    RunReport report = MotionSession(run_, *this, watch_).Run();
    End();
    report.timings = loop_->timings();
    report.deviation = loop_->deviation();
    report.controller_overruns = controller_loop_.overruns();
    report.notices = communication_.notices();
    if (controller_) AddNew(controller_->notices(), report.notices);
    if (watch_.failure() != LoopFailure::kNone) report.evidence = loop_->LastTicks();
    return report;
  }

  [[nodiscard]] Time Now() const override { return clock_.Now(); }
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool()>& done) override {
    while (!done()) {
      if (clock_.Now() >= limit) return false;
      rt::SleepUntil(clock_, clock_.Now() + kLook);
    }
    return true;
  }
  [[nodiscard]] const RobotState& State() override { return communication_.State(); }
  void Activate(const MotionModes& modes) override {
    DoOnCommunication([&] { loop_->Activate(modes); });
  }
  void StopController() override {
    if (controller_) {
      controller_->Stop();
    } else if (watch_.failure() == LoopFailure::kNone ||
               watch_.failure() == LoopFailure::kInvalidCommand) {
      DoOnCommunication([&] { loop_->StopController(); });
    }
  }

 private:
  template <typename Function>
  void DoOnCommunication(Function function) {
    rt::FunctionCall<Function> call(function);
    if (communication_.Execute(call)) return;
    throw EnvironmentError(
        "the communication thread has not run for 1 s; this machine gives it no time (see "
        "panda-twin check)");
  }

  /// Ends both threads; afterwards nothing puts ticks or calls the controller.
  void End() {
    if (controller_) controller_->Stop();
    communication_.Stop();
  }

  const MonotonicClock& clock_;
  const MotionRun& run_;
  Exchange exchange_;
  MotionWatch watch_;
  rt::Signal moving_;
  ControlTick tick_;
  std::unique_ptr<CommunicationLoop> loop_;
  ControllerLoop controller_loop_;
  CommunicationThread communication_;
  std::optional<ControllerThread> controller_;
};

}  // namespace

RobotCycles::RobotCycles(const backend::Connection& connection) : robot_(connection.robot_time) {
  if (robot_ != nullptr) robot_->Begin();
}

RobotCycles::~RobotCycles() {
  if (robot_ != nullptr) robot_->End();
}

backend::RobotTimings RobotCycles::End() {
  if (robot_ == nullptr) return {};
  robot_->End();
  return robot_->timings();
}

RunReport RunInRealtime(const MonotonicClock& clock, const backend::Connection& connection,
                        const MotionRun& run, const RealtimeThreads& threads) {
  TWIN_CHECK(connection.arrival != nullptr);
  const MotionRun measured = WithoutModels(run);
  RealtimeStage stage(clock, connection, measured, threads);
  return stage.Run();
}

}  // namespace twin::loop

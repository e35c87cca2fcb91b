#include "twin/loop/drive.h"

#include <utility>

#include "loop/motion_runner.h"
#include "twin/core/error.h"
#include "twin/loop/state_time_loop.h"

namespace twin::loop {
namespace {

/// Longest wait for a state between two checks of the caller's condition.
constexpr Duration kStatePoll = std::chrono::milliseconds(50);

/// Removes costs and tolerances, which have no meaning where states are the time.
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

/// Progress of the robot's states over several motions.
struct StateTimeline {
  std::uint64_t first_id = 0;  ///< message_id of the state at time zero; 0: the next state read
  Time now{};                  ///< time of the state read last
};

class StateTimeRunner final : public MotionRunner {
 public:
  StateTimeRunner(const MonotonicClock& clock, rt::Arrival& arrival, const MotionRun& run,
                  StateTimeline& timeline)
      : MotionRunner(run), clock_(clock), arrival_(arrival), timeline_(timeline) {
    auto loop = std::make_unique<StateTimeLoop>(tick_, run.backend, run.sink, controller_loop_,
                                                timeline.first_id, timeline.now);
    states_ = loop.get();
    loop_ = std::move(loop);
    loop_->RecordStates(true);
    static_cast<void>(loop_->Start(Now()));
  }
  ~StateTimeRunner() override { timeline_ = {states_->first_id(), states_->now()}; }

 private:
  [[nodiscard]] Time Now() const override { return states_->now(); }
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool()>& done) override {
    while (!done()) {
      if (Now() >= limit || lost_) return false;
      Step();
    }
    return true;
  }
  void StopController() override { loop_->StopController(); }

  /// Handles one state, if one arrives in time.
  void Step() {
    switch (loop_->OnState()) {
      case CommunicationLoop::Outcome::kPending:
        static_cast<void>(arrival_.AwaitUntil(clock_.Now() + kStatePoll));
        return;
      case CommunicationLoop::Outcome::kLost:
        lost_ = true;
        watch_.Fail(LoopFailure::kConnectionLost);
        return;
      case CommunicationLoop::Outcome::kComputing: break;
    }
    loop_->Write();
    static_cast<void>(loop_->OnDone(Now()));
    static_cast<void>(watch_.Observe(loop_->InMotion(), Now()));
    if (loop_->record().action == record::TickAction::kInvalid) {
      watch_.Fail(LoopFailure::kInvalidCommand);
    }
    if (loop_->stopped_by_limit()) watch_.Fail(LoopFailure::kLimit);
  }

  const MonotonicClock& clock_;
  rt::Arrival& arrival_;
  StateTimeline& timeline_;
  StateTimeLoop* states_ = nullptr;  ///< loop_
  bool lost_ = false;
};

class StateTimeDrive final : public Drive {
 public:
  StateTimeDrive(std::unique_ptr<MonotonicClock> clock, backend::Connection connection)
      : clock_(std::move(clock)), connection_(std::move(connection)) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] const MonotonicClock* wall_clock() const noexcept override { return clock_.get(); }
  [[nodiscard]] Time Now() const override { return timeline_.now; }

  void Begin() override { clock_->Restart(); }
  [[nodiscard]] RunReport Run(const MotionRun& run) override {
    const MotionRun on_states = OnStates(run);
    return StateTimeRunner(*clock_, *connection_.arrival, on_states, timeline_).Run();
  }

 private:
  void Wait(Time /*limit*/) override {
    constexpr Duration kShortLook = std::chrono::milliseconds(5);
    static_cast<void>(connection_.arrival->AwaitUntil(clock_->Now() + kShortLook));
  }
  void Observe(const RobotState& state) override {
    if (timeline_.first_id == 0) timeline_.first_id = state.message_id;
    const std::uint64_t cycles = state.message_id - timeline_.first_id;
    timeline_.now = Time(kCycle * static_cast<std::int64_t>(cycles));
  }

  const std::unique_ptr<MonotonicClock> clock_;  ///< outlives the backend
  StateTimeline timeline_;
  backend::Connection connection_;
};

}  // namespace

std::unique_ptr<Drive> MakeStateTimeDrive(std::unique_ptr<MonotonicClock> clock,
                                          backend::Connection connection) {
  return std::make_unique<StateTimeDrive>(std::move(clock), std::move(connection));
}

}  // namespace twin::loop

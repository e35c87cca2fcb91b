#include "twin/loop/lockstep_drive.h"

#include <memory>

#include "loop/motion_session.h"
#include "twin/loop/control_tick.h"
#include "twin/loop/controller_loop.h"
#include "twin/loop/exchange.h"

namespace twin::loop {
namespace {

class LockstepStage;

/// Hands the queue's events to the motion they were scheduled for. It outlives the motions: an
/// event that is still pending when its motion is over reaches nobody.
class Port final : public rt::EventHandler {
 public:
  using Step = void (LockstepStage::*)(Time) noexcept;
  explicit Port(Step step) : step_(step) {}

  void Attach(LockstepStage* stage) noexcept {
    stage_ = stage;
    ++serial_;
  }
  void Schedule(rt::EventQueue& events, Time at, rt::EventOrder order) noexcept {
    events.Schedule(at, order, *this, serial_);
  }
  void OnEvent(Time now, std::uint64_t serial) noexcept override;

 private:
  Step step_;
  LockstepStage* stage_ = nullptr;
  std::uint64_t serial_ = 0;
};

/// The ports of a drive.
struct Ports {
  Port read_begin;
  Port tick_done;
  Port controller_wake;
  Port controller_done;
};

/// Runs the loops of one motion from the event queue.
class LockstepStage final : public Stage {
 public:
  LockstepStage(rt::EventQueue& events, const MotionRun& run, Ports& ports)
      : events_(events),
        run_(run),
        ports_(ports),
        tick_(run.tick, run.controller.command_interface(), exchange_),
        loop_(MakeLoop(run, tick_, exchange_)),
        controller_loop_(run.controller_loop, run.controller, exchange_, run.seed) {}

  RunReport Run();

  /// A state has arrived.
  void OnState(Time now) noexcept {
    if (reading_) Look(now);
  }
  void OnReadBegin(Time now) noexcept {
    reading_ = true;
    Look(now);
  }
  void OnTickDone(Time now) noexcept;
  void OnControllerWake(Time now) noexcept;
  void OnControllerDone(Time now) noexcept { ScheduleWake(controller_loop_.OnDone(now)); }

  [[nodiscard]] Time Now() const override { return events_.Now(); }
  [[nodiscard]] bool PassUntil(Time limit, const std::function<bool()>& done) override {
    while (!done()) {
      if (events_.Now() >= limit || !events_.RunNext()) return false;
    }
    return true;
  }
  [[nodiscard]] const RobotState& State() override { return loop_->state(); }
  void Activate(const MotionModes& modes) override { loop_->Activate(modes); }
  void StopController() override { controller_stopped_ = true; }

 private:
  void Look(Time now) noexcept;
  void ScheduleWake(Time at) noexcept {
    ports_.controller_wake.Schedule(events_, at, rt::EventOrder::kControllerWake);
  }

  rt::EventQueue& events_;
  const MotionRun& run_;
  Ports& ports_;
  Exchange exchange_;
  ControlTick tick_;
  std::unique_ptr<CommunicationLoop> loop_;
  ControllerLoop controller_loop_;
  MotionWatch watch_;
  bool reading_ = false;
  bool controller_stopped_ = false;
};

void Port::OnEvent(Time now, std::uint64_t serial) noexcept {
  if (stage_ != nullptr && serial == serial_) (stage_->*step_)(now);
}

void LockstepStage::Look(Time now) noexcept {
  switch (loop_->OnState()) {
    case CommunicationLoop::Outcome::kPending: return;
    case CommunicationLoop::Outcome::kLost: watch_.Fail(LoopFailure::kConnectionLost); return;
    case CommunicationLoop::Outcome::kComputing: break;
  }
  reading_ = false;
  ports_.tick_done.Schedule(events_, now + loop_->cost(), rt::EventOrder::kTickDone);
  const bool begins = watch_.Observe(loop_->InMotion(), now);
  if (begins && run_.kind == LoopKind::kAsynchronous) ScheduleWake(controller_loop_.Start(now));
}

void LockstepStage::OnTickDone(Time now) noexcept {
  loop_->Write();
  const Time next = loop_->OnDone(now);
  if (loop_->record().action == rt::TickAction::kInvalid) {
    watch_.Fail(LoopFailure::kInvalidCommand);
  }
  if (next <= now) {
    OnReadBegin(now);
  } else {
    ports_.read_begin.Schedule(events_, next, rt::EventOrder::kReadBegin);
  }
}

void LockstepStage::OnControllerWake(Time now) noexcept {
  if (controller_stopped_ || watch_.ended()) return;
  if (controller_loop_.OnWake(now)) {
    ports_.controller_done.Schedule(events_, now + controller_loop_.cost(),
                                    rt::EventOrder::kControllerDone);
  } else {
    ScheduleWake(controller_loop_.NextWake(now));
  }
}

RunReport LockstepStage::Run() {
  const Time now = events_.Now();
  const Time first = loop_->Start(now);
  if (first <= now) {
    OnReadBegin(now);
  } else {
    ports_.read_begin.Schedule(events_, first, rt::EventOrder::kReadBegin);
  }
  RunReport report = MotionSession(run_, *this, watch_).Run();
  report.timings = loop_->timings();
  report.deviation = loop_->deviation();
  report.controller_overruns = controller_loop_.overruns();
  if (watch_.failure() != LoopFailure::kNone) report.evidence = loop_->LastTicks();
  return report;
}

}  // namespace

class LockstepDrive::Impl final : public rt::EventHandler {
 public:
  void OnEvent(Time now, std::uint64_t /*message_id*/) noexcept override {
    if (stage_ != nullptr) stage_->OnState(now);
  }

  RunReport Run(rt::EventQueue& events, const MotionRun& run) {
    LockstepStage stage(events, run, ports_);
    Attach(&stage);
    const struct Detach {
      Impl& impl;
      ~Detach() { impl.Attach(nullptr); }
    } detach{*this};
    return stage.Run();
  }

 private:
  void Attach(LockstepStage* stage) noexcept {
    stage_ = stage;
    for (Port* port : {&ports_.read_begin, &ports_.tick_done, &ports_.controller_wake,
                       &ports_.controller_done}) {
      port->Attach(stage);
    }
  }

  LockstepStage* stage_ = nullptr;
  Ports ports_{Port(&LockstepStage::OnReadBegin), Port(&LockstepStage::OnTickDone),
               Port(&LockstepStage::OnControllerWake), Port(&LockstepStage::OnControllerDone)};
};

LockstepDrive::LockstepDrive() : impl_(std::make_unique<Impl>()) {}
LockstepDrive::~LockstepDrive() = default;

rt::EventHandler& LockstepDrive::StateReady() noexcept {
  return *impl_;
}

RunReport LockstepDrive::Run(rt::EventQueue& events, const MotionRun& run) {
  return impl_->Run(events, run);
}

}  // namespace twin::loop

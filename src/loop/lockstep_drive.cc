#include <memory>
#include <utility>

#include "loop/motion_runner.h"
#include "twin/loop/drive.h"
#include "twin/robot/robot.h"
#include "twin/rt/event_queue.h"

namespace twin::loop {
namespace {

class LockstepRunner;

/// Forwards the queue's events to the motion that they were scheduled for. It outlives the motions:
/// an event that is still pending when its motion has ended is ignored.
class Port final : public rt::EventHandler {
 public:
  using Step = void (LockstepRunner::*)(Time) noexcept;
  explicit Port(Step step) : step_(step) {}

  void Attach(LockstepRunner* runner) noexcept {
    runner_ = runner;
    ++serial_;
  }
  void Schedule(rt::EventQueue& events, Time at, rt::EventOrder order) noexcept {
    events.Schedule(at, order, *this, serial_);
  }
  void OnEvent(Time now, std::uint64_t serial) noexcept override;

 private:
  Step step_;
  LockstepRunner* runner_ = nullptr;
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
class LockstepRunner final : public MotionRunner {
 public:
  LockstepRunner(rt::EventQueue& events, const MotionRun& run, Ports& ports)
      : MotionRunner(run), events_(events), ports_(ports) {
    loop_ = MakeLoop(run, tick_, exchange_);
  }

  void Begin();

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
  void StopController() override { controller_stopped_ = true; }

 private:
  void Look(Time now) noexcept;
  void ScheduleWake(Time at) noexcept {
    ports_.controller_wake.Schedule(events_, at, rt::EventOrder::kControllerWake);
  }

  rt::EventQueue& events_;
  Ports& ports_;
  bool reading_ = false;
  bool controller_stopped_ = false;
};

void Port::OnEvent(Time now, std::uint64_t serial) noexcept {
  if (runner_ != nullptr && serial == serial_) (runner_->*step_)(now);
}

void LockstepRunner::Look(Time now) noexcept {
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

void LockstepRunner::OnTickDone(Time now) noexcept {
  loop_->Write();
  const Time next = loop_->OnDone(now);
  if (loop_->record().action == record::TickAction::kInvalid) {
    watch_.Fail(LoopFailure::kInvalidCommand);
  }
  if (loop_->stopped_by_limit()) watch_.Fail(LoopFailure::kLimit);
  if (next <= now) {
    OnReadBegin(now);
  } else {
    ports_.read_begin.Schedule(events_, next, rt::EventOrder::kReadBegin);
  }
}

void LockstepRunner::OnControllerWake(Time now) noexcept {
  if (controller_stopped_ || watch_.ended()) return;
  if (controller_loop_.OnWake(now)) {
    ports_.controller_done.Schedule(events_, now + controller_loop_.cost(),
                                    rt::EventOrder::kControllerDone);
  } else {
    ScheduleWake(controller_loop_.NextWake(now));
  }
}

void LockstepRunner::Begin() {
  const Time now = events_.Now();
  const Time first = loop_->Start(now);
  if (first <= now) {
    OnReadBegin(now);
  } else {
    ports_.read_begin.Schedule(events_, first, rt::EventOrder::kReadBegin);
  }
}

class LockstepDrive final : public Drive, private rt::EventHandler {
 public:
  LockstepDrive(const backend::Factory& connect, const robot::RobotConfig& robot,
                record::RecordSink* sink)
      : connection_(connect({robot, backend::VirtualTime{events_, *this}, sink})) {}

  [[nodiscard]] const backend::Connection& connection() const noexcept override {
    return connection_;
  }
  [[nodiscard]] Time Now() const override { return events_.Now(); }

  [[nodiscard]] RunReport Run(const MotionRun& run) override {
    LockstepRunner runner(events_, run, ports_);
    Attach(&runner);
    const struct Detach {
      LockstepDrive& drive;
      ~Detach() { drive.Attach(nullptr); }
    } detach{*this};
    runner.Begin();
    return runner.Run();
  }

  /// While other arms of the same model move, INT holds this one.
  backend::RobotTimings End() override {
    robot::Robot* const robot = connection_.lockstep_robot;
    if (robot == nullptr) return {};
    robot->StandBy();
    while (robot->is_awaited() && events_.RunNext()) {
    }
    return {};
  }

  [[nodiscard]] std::unique_ptr<const Drive::Snapshot> Save() const override {
    if (connection_.lockstep_robot == nullptr) return Drive::Save();
    return std::make_unique<Saved>(events_, connection_.lockstep_robot->Save());
  }
  /// Events of motions that have ended since are not lost, but ignored: a port's serial never goes
  /// back.
  void Restore(const Drive::Snapshot& snapshot) override {
    if (connection_.lockstep_robot == nullptr) return Drive::Restore(snapshot);
    const auto& saved = dynamic_cast<const Saved&>(snapshot);
    events_ = saved.events;
    connection_.lockstep_robot->Restore(saved.robot);
  }

 private:
  struct Saved final : Drive::Snapshot {
    Saved(const rt::EventQueue& queue, robot::Robot::Snapshot copy)
        : events(queue), robot(std::move(copy)) {}
    rt::EventQueue events;
    robot::Robot::Snapshot robot;
  };

  void Wait(Time /*limit*/) override { static_cast<void>(events_.RunNext()); }

  /// A state has arrived.
  void OnEvent(Time now, std::uint64_t /*message_id*/) noexcept override {
    if (runner_ != nullptr) runner_->OnState(now);
  }
  void Attach(LockstepRunner* runner) noexcept {
    runner_ = runner;
    for (Port* port : {&ports_.read_begin, &ports_.tick_done, &ports_.controller_wake,
                       &ports_.controller_done}) {
      port->Attach(runner);
    }
  }

  LockstepRunner* runner_ = nullptr;
  Ports ports_{Port(&LockstepRunner::OnReadBegin), Port(&LockstepRunner::OnTickDone),
               Port(&LockstepRunner::OnControllerWake), Port(&LockstepRunner::OnControllerDone)};
  // The backend's robot uses the queue and notifies the drive, so the queue must outlive it.
  rt::EventQueue events_;
  backend::Connection connection_;
};

}  // namespace

std::unique_ptr<Drive> MakeLockstepDrive(const backend::Factory& connect,
                                         const robot::RobotConfig& robot,
                                         record::RecordSink* sink) {
  return std::make_unique<LockstepDrive>(connect, robot, sink);
}

}  // namespace twin::loop

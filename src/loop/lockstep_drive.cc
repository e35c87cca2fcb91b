#include "twin/loop/lockstep_drive.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/loop/control_tick.h"
#include "twin/loop/controller_loop.h"
#include "twin/loop/exchange.h"
#include "twin/loop/tick_loop.h"

namespace twin::loop {
namespace {

/// Run on after the motion, so that the log shows the robot idle (or in Reflex, coming to rest).
constexpr Duration kAfterMotion = std::chrono::milliseconds(500);
constexpr Duration kAfterSuccess = std::chrono::milliseconds(20);
/// Longest wait for a first state, and for a stopped arm to come to rest.
constexpr Duration kPatience = std::chrono::seconds(3);
constexpr const char* kInterrupted = "interrupted";
/// Without a state for so long, the backend is asked whether the motion has ended.
constexpr Duration kSilence = std::chrono::milliseconds(500);
constexpr Duration kProgressPeriod = std::chrono::milliseconds(100);

class Motion;

/// Hands the queue's events to the motion they were scheduled for. It outlives the motions: an
/// event that is still pending when its motion is over reaches nobody.
class Port final : public rt::EventHandler {
 public:
  using Step = void (Motion::*)(Time) noexcept;
  explicit Port(Step step) : step_(step) {}

  void Attach(Motion* motion) noexcept {
    motion_ = motion;
    ++serial_;
  }
  void Schedule(rt::EventQueue& events, Time at, rt::EventOrder order) noexcept {
    events.Schedule(at, order, *this, serial_);
  }
  void OnEvent(Time now, std::uint64_t serial) noexcept override;

 private:
  Step step_;
  Motion* motion_ = nullptr;
  std::uint64_t serial_ = 0;
};

/// The ports of a drive.
struct Ports {
  Port tick_done;
  Port controller_wake;
  Port controller_done;
};

/// Runs the loops of one motion from the event queue.
class Motion final {
 public:
  Motion(const LockstepRun& run, Ports& ports)
      : run_(run),
        ports_(ports),
        tick_(run.tick, run.controller.command_interface(), exchange_),
        tick_loop_(tick_, run.backend, run.tick.cost, run.seed, run.sink),
        controller_loop_(run.controller_loop, run.controller, exchange_, run.seed) {}

  void OnState(Time now) noexcept {
    if (!tick_loop_.OnState()) return;
    last_state_ = now;
    ports_.tick_done.Schedule(run_.events, now + tick_loop_.cost(), rt::EventOrder::kTickDone);
    const bool in_motion = started_ && tick_.InMotion(tick_loop_.state());
    if (in_motion && !seen_in_motion_) {
      seen_in_motion_ = true;
      ScheduleWake(controller_loop_.Start(now));
    }
    if (seen_in_motion_ && !in_motion && !end_) end_ = now;
  }

  /// Runs events until `done()`; checks for progress and interruption in between.
  template <typename Done>
  bool RunUntil(Time limit, Done&& done) {
    while (!done()) {
      if (run_.events.Now() >= limit || !run_.events.RunNext()) return false;
      ReportProgress();
      if (Interrupted() && !stopping_) return false;
    }
    return true;
  }

  RunReport Run();

  void OnTickDone(Time now) noexcept { tick_loop_.OnDone(now); }

  void OnControllerWake(Time now) noexcept {
    if (end_) return;
    if (controller_loop_.OnWake(now)) {
      ports_.controller_done.Schedule(run_.events, now + controller_loop_.cost(),
                                      rt::EventOrder::kControllerDone);
    } else {
      ScheduleWake(controller_loop_.NextWake(now));
    }
  }

  void OnControllerDone(Time now) noexcept { ScheduleWake(controller_loop_.OnDone(now)); }

 private:
  void ScheduleWake(Time at) noexcept {
    ports_.controller_wake.Schedule(run_.events, at, rt::EventOrder::kControllerWake);
  }

  [[nodiscard]] bool Interrupted() const noexcept {
    return run_.interrupted != nullptr && *run_.interrupted;
  }

  void ReportProgress() {
    if (run_.events.Now() < next_progress_) return;
    next_progress_ = run_.events.Now() + kProgressPeriod;
    NoticeSilentEnd();
    if (run_.progress) run_.progress(run_.events.Now());
  }

  /// The robot has ended the motion, but no state comes through that would say so.
  void NoticeSilentEnd() {
    const Time now = run_.events.Now();
    if (!started_ || end_ || now - last_state_ < kSilence) return;
    if (run_.backend.Describe().last_end != backend::MotionEnd::kNone) end_ = now;
  }

  void Tell(std::string_view kind, std::string_view text) {
    if (run_.event) run_.event(run_.events.Now(), kind, text);
  }

  void StopEarly(RunReport& report, std::string why);
  void Conclude(RunReport& report);

  const LockstepRun& run_;
  Ports& ports_;
  Exchange exchange_;
  ControlTick tick_;
  TickLoop tick_loop_;
  ControllerLoop controller_loop_;

  bool started_ = false;
  bool seen_in_motion_ = false;
  bool stopping_ = false;
  std::optional<Time> end_;
  Time last_state_{};  ///< when the last state was read
  Time next_progress_{};
};

void Port::OnEvent(Time now, std::uint64_t serial) noexcept {
  if (motion_ != nullptr && serial == serial_) (motion_->*step_)(now);
}

RunReport Motion::Run() {
  RunReport report;
  const Time begin = run_.events.Now();
  if (!RunUntil(begin + kPatience, [&] { return tick_loop_.state().message_id != 0; })) {
    if (Interrupted()) {
      report.failure = kInterrupted;
      return report;
    }
    throw RobotFault("no robot state arrived within 3 s; is the link losing every state?");
  }
  run_.controller.Activate(tick_loop_.state(), run_.events.Now());
  tick_.Activate(run_.modes);
  run_.backend.Start(run_.modes);
  started_ = true;
  Tell("motion",
       fmt::format("started: {} with {}", Name(run_.modes.generator), Name(run_.modes.controller)));

  if (!RunUntil(begin + run_.time_limit, [&] { return end_.has_value(); })) {
    StopEarly(report, Interrupted() ? std::string(kInterrupted)
                                    : fmt::format("the motion did not end within {} s of run time",
                                                  ToSeconds(run_.time_limit)));
  }
  Conclude(report);
  return report;
}

void Motion::StopEarly(RunReport& report, std::string why) {
  report.failure = std::move(why);
  Tell("stop", report.failure);
  stopping_ = true;
  run_.backend.Stop();
  if (!RunUntil(run_.events.Now() + kPatience, [&] { return end_.has_value(); })) {
    report.failure += "; no state has come through that shows the arm at rest";
  }
}

void Motion::Conclude(RunReport& report) {
  run_.controller.Deactivate();
  const backend::Description description = run_.backend.Describe();
  report.end = description.last_end;
  report.errors = description.last_errors;
  report.violations = description.violations;
  for (const Violation& violation : report.violations) Tell("error", Describe(violation));
  if (report.end == backend::MotionEnd::kAborted && report.failure.empty()) {
    report.failure = fmt::format("motion aborted by reflex {}", FormatErrors(report.errors));
  }
  Tell("motion", report.end == backend::MotionEnd::kSuccess ? "finished" : report.failure);

  stopping_ = true;
  const Duration rest = report.end == backend::MotionEnd::kSuccess ? kAfterSuccess : kAfterMotion;
  const Time until = run_.events.Now() + rest;
  static_cast<void>(RunUntil(until, [] { return false; }));

  const RobotState& last = tick_loop_.state();
  report.simulated = run_.events.Now().time_since_epoch();
  report.written = tick_loop_.written();
  report.skipped_states = tick_loop_.skipped_states();
  report.q_final = last.q;
}

}  // namespace

class LockstepDrive::Impl final : public rt::EventHandler {
 public:
  void OnEvent(Time now, std::uint64_t /*message_id*/) noexcept override {
    if (motion_ != nullptr) motion_->OnState(now);
  }

  RunReport Run(const LockstepRun& run) {
    Motion motion(run, ports_);
    Attach(&motion);
    const struct Detach {
      Impl& impl;
      ~Detach() { impl.Attach(nullptr); }
    } detach{*this};
    return motion.Run();
  }

 private:
  void Attach(Motion* motion) noexcept {
    motion_ = motion;
    ports_.tick_done.Attach(motion);
    ports_.controller_wake.Attach(motion);
    ports_.controller_done.Attach(motion);
  }

  Motion* motion_ = nullptr;
  Ports ports_{Port(&Motion::OnTickDone), Port(&Motion::OnControllerWake),
               Port(&Motion::OnControllerDone)};
};

LockstepDrive::LockstepDrive() : impl_(std::make_unique<Impl>()) {}
LockstepDrive::~LockstepDrive() = default;

rt::EventHandler& LockstepDrive::StateReady() noexcept {
  return *impl_;
}

RunReport LockstepDrive::Run(const LockstepRun& run) {
  return impl_->Run(run);
}

}  // namespace twin::loop

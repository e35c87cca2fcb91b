#include "loop/motion_runner.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/loop/asynchronous_loop.h"
#include "twin/loop/inline_loops.h"

namespace twin::loop {
namespace {

/// Time of the run after the motion, so that the log shows the robot idle (or in Reflex, stopping).
constexpr Duration kAfterMotion = std::chrono::milliseconds(500);
/// The same after a success, and where somebody waits for the end.
constexpr Duration kAfterSuccess = std::chrono::milliseconds(20);
/// Longest wait for an arm that still moves after that: the robot's own timeout plus the time of
/// its brakes.
constexpr Duration kUntilRest = kRestTimeout + std::chrono::milliseconds(300);
/// Time below kRestSpeed after which a run may end: half of the robot's kRestTime, because the
/// robot observes for longer.
constexpr Duration kStill = kRestTime / 2;
/// Longest wait for a first state, and for a stopped arm to come to rest.
constexpr Duration kMotionTimeout = std::chrono::seconds(3);
constexpr const char* kInterrupted = "interrupted";
/// Time without a state after which the runner asks the backend whether the motion has ended.
constexpr Duration kSilence = std::chrono::milliseconds(500);
constexpr Duration kLookPeriod = std::chrono::milliseconds(100);

const char* Text(LoopFailure failure) {
  switch (failure) {
    case LoopFailure::kNone: break;
    case LoopFailure::kInvalidCommand:
      return "the controller gave up and does not say why, or gave a target that makes no valid "
             "command (not finite, or no rotation); the motion was stopped. The log's events of "
             "kind evidence are its last ticks";
    case LoopFailure::kLimit: break;  // WhyNotEnded() has value and bound
    case LoopFailure::kConnectionLost:
      return "the connection to the robot is gone; see whether the robot (or its server) still "
             "runs";
    case LoopFailure::kException:
      return "the communication thread failed; the motion was stopped. Please report it";
  }
  return "";
}

}  // namespace

std::string NoStateFor(Duration silence) {
  return fmt::format("no robot state has come for {} s; is the link losing every state?",
                     ToSeconds(silence));
}

MotionRun WithoutModels(MotionRun run) {
  run.tick.cost = faults::DelayModel();
  run.controller_loop.cost = faults::DelayModel();
  run.controller_loop.wake_delay = faults::DelayModel();
  return run;
}

std::unique_ptr<CommunicationLoop> MakeLoop(const MotionRun& run, ControlTick& tick,
                                            Exchange& exchange) {
  switch (run.kind) {
    case LoopKind::kSynchronous:
      return std::make_unique<SynchronousLoop>(tick, run.backend, run.sink, run.controller,
                                               exchange, run.tick, run.controller_loop, run.seed);
    case LoopKind::kBare:
      return std::make_unique<BareLoop>(tick, run.backend, run.sink, run.controller, exchange,
                                        run.tick, run.controller_loop, run.seed);
    case LoopKind::kAsynchronous: break;
  }
  return std::make_unique<AsynchronousLoop>(tick, run.backend, run.tick.cost, run.seed, run.sink);
}

MotionRunner::MotionRunner(const MotionRun& run)
    : run_(run),
      tick_(run.tick, run.controller.command_interface(), exchange_),
      controller_loop_(run.controller_loop, run.controller, exchange_, run.seed) {}

RunReport MotionRunner::Run() {
  RunReport report = RunToEnd();
  EndThreads();
  report.timings = loop_->timings();
  report.deviation = loop_->deviation();
  report.controller_overruns = controller_loop_.overruns();
  if (watch_.failure() != LoopFailure::kNone) report.evidence = loop_->LastTicks();
  if (watch_.failure() == LoopFailure::kLimit) report.limit = tick_.breach();
  return report;
}

RunReport MotionRunner::RunToEnd() {
  RunReport report;
  const Time begin = Now();
  if (!Pass(begin + kMotionTimeout, [&] { return watch_.has_state(); })) {
    if (Interrupted()) {
      report.failure = kInterrupted;
      return report;
    }
    throw RobotFault("no robot state arrived within 3 s; is the link losing every state?");
  }
  run_.controller.Activate(State(), Now());
  Activate(run_.modes);
  watch_.Expect();
  run_.backend.Start(run_.modes);
  Tell("motion",
       fmt::format("started: {} with {}", Name(run_.modes.generator), Name(run_.modes.controller)));

  if (!Pass(begin + run_.time_limit, [&] { return watch_.ended(); })) {
    StopEarly(report, WhyNotEnded());
  }
  Conclude(report);
  return report;
}

bool MotionRunner::Pass(Time limit, const std::function<bool()>& done) {
  bool given_up = false;
  const bool in_time = PassUntil(limit, [&] {
    Attend();
    LookOn();
    WatchRest();
    // A failure comes first: the stop it led to may already have ended the motion.
    given_up = !stopping_ && (Interrupted() || deaf_ || watch_.failure() != LoopFailure::kNone);
    return given_up || done();
  });
  return in_time && !given_up;
}

void MotionRunner::Attend() {
  const Time now = Now();
  if (run_.attend && now >= next_attendance_) next_attendance_ = run_.attend(now);
}

void MotionRunner::WatchRest() {
  if (!watch_.has_state()) return;
  const RobotState& state = State();
  if (newest_ == 0) rest_.Restart(state.message_id);
  if (state.message_id != newest_) rest_.Observe(state.message_id, state.dq);
  newest_ = state.message_id;
}

void MotionRunner::LookOn() {
  const Time now = Now();
  if (now < next_look_) return;
  // If this thread has not run for long, it cannot conclude that the others were silent.
  if (now > next_look_ + kSilence) silent_since_ = now;
  next_look_ = now + kLookPeriod;
  if (watch_.expected() && !watch_.ended()) NoticeSilence();
  if (watch_.expected() && !watch_.moving()) NoticeUnseenEnd();
  if (run_.progress) run_.progress(now);
}

void MotionRunner::NoticeUnseenEnd() {
  // A motion that ended in its first cycle does not appear in any state.
  if (run_.backend.Describe().last_end != backend::MotionEnd::kNone) watch_.End();
}

void MotionRunner::NoticeSilence() {
  const Duration silence = Now() - std::max(watch_.last_state(), silent_since_);
  if (silence < kSilence) return;
  if (run_.backend.Describe().last_end != backend::MotionEnd::kNone) {
    watch_.End();
  } else if (silence >= run_.silence) {
    deaf_ = true;
  }
}

std::string MotionRunner::WhyNotEnded() const {
  if (Interrupted()) return kInterrupted;
  if (watch_.failure() == LoopFailure::kLimit) {
    return fmt::format("lab_limit: {}; the arm was stopped before it",
                       onboard::Describe(run_.tick.lab.value(), tick_.breach().value()));
  }
  if (watch_.failure() != LoopFailure::kNone) return Text(watch_.failure());
  if (deaf_) return NoStateFor(run_.silence);
  return fmt::format("the motion did not end within {} s of run time", ToSeconds(run_.time_limit));
}

void MotionRunner::StopEarly(RunReport& report, std::string why) {
  report.failure = std::move(why);
  stopping_ = true;
  run_.backend.Stop();
  const LoopFailure failure = watch_.failure();
  if (failure == LoopFailure::kInvalidCommand) {
    // From here on, no other thread calls the controller.
    StopController();
    const std::string reason = run_.controller.Explain();
    if (!reason.empty()) report.failure = reason + "; the motion was stopped";
  }
  Tell(failure == LoopFailure::kLimit ? "limit" : "stop", report.failure);
  if (failure == LoopFailure::kConnectionLost || failure == LoopFailure::kException) return;
  if (!Pass(Now() + kMotionTimeout, [&] { return watch_.ended(); })) {
    report.failure += "; no state has come through that shows the arm at rest";
  }
}

void MotionRunner::JudgeRest(RunReport& report) {
  constexpr auto kInstability = static_cast<std::size_t>(RobotError::kInstabilityDetected);
  const RobotState& state = State();
  std::string why;
  if (report.errors.test(kInstability)) return;  // it ended the motion and is reported already
  if (state.errors.test(kInstability)) {
    why = "the arm did not come to rest; the robot closed its brakes: instability_detected";
    report.errors |= state.errors;
  } else if (rest_.Still() < kStill && !deaf_ && watch_.failure() == LoopFailure::kNone) {
    const std::size_t joint = FastestJoint(state.dq);
    why = Now() - watch_.last_state() < run_.silence
              ? fmt::format("the arm did not come to rest: joint {} still moves at {:.3g} rad/s",
                            joint + 1, state.dq[joint])
              : "the robot's states have stopped: nothing shows whether the arm came to rest";
  } else {
    return;
  }
  Tell("rest", why);
  if (!report.failure.empty()) why = fmt::format("{}; then {}", report.failure, why);
  report.failure = std::move(why);
}

void MotionRunner::Conclude(RunReport& report) {
  StopController();
  run_.controller.Deactivate();
  const backend::Description description = run_.backend.Describe();
  report.end = description.last_end;
  report.errors = description.last_errors;
  report.violations = description.violations;
  for (const Violation& violation : report.violations) Tell("error", Describe(violation));
  if (report.end == backend::MotionEnd::kAborted && report.failure.empty()) {
    report.failure = fmt::format("motion aborted by reflex {}", FormatErrors(report.errors));
  }
  if (report.end == backend::MotionEnd::kUserStopped && report.failure.empty()) {
    report.failure = "motion aborted: user stop pressed";
  }
  if (report.end == backend::MotionEnd::kPreempted && report.failure.empty()) {
    report.failure =
        "the robot's side stopped the motion, and says there why; a twin served in lockstep stops "
        "one whose states are not answered for --session-timeout";
  }
  Tell("motion", report.end == backend::MotionEnd::kSuccess ? "finished" : report.failure);

  stopping_ = true;
  const bool is_short = report.end == backend::MotionEnd::kSuccess || Interrupted();
  const Duration rest = is_short ? kAfterSuccess : kAfterMotion;
  const Time end = Now();
  static_cast<void>(Pass(end + rest, [] { return false; }));
  static_cast<void>(Pass(end + kUntilRest, [this] { return rest_.Still() >= kStill; }));
  JudgeRest(report);
  report.simulated = Now().time_since_epoch();
  report.q_final = State().q;
}

}  // namespace twin::loop

#include "twin/robot/answer_paced_robot.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::robot {
namespace {

/// How long the thread waits for commands between checks for other requests.
constexpr Duration kLook = kCycle;
/// Time after which an unanswered state is sent again.
constexpr Duration kResend = std::chrono::milliseconds(100);
/// While frozen, before a motion's first command: time from the first state that shows the motion
/// to the second, for which clients wait, and to each further one, for a client that took the first
/// two as one. A state that crosses the first command would be one more for that client, so the
/// pause is as long as clients of the real robot wait (they give up after 1 s).
constexpr Duration kToSecond = std::chrono::milliseconds(10);
constexpr Duration kToFurther = std::chrono::milliseconds(500);
/// Delays of a paced robot up to this are made up for.
constexpr Duration kMostBehind = std::chrono::milliseconds(100);
/// Consecutive states that the link may lose before the robot stops waiting for a change of mode.
constexpr int kMostLost = 64;

/// "a, b, c".
template <typename Value>
std::string NamesOf(const std::map<std::string, Value>& named) {
  std::string names;
  for (const auto& [name, value] : named) names += (names.empty() ? "" : ", ") + name;
  return names;
}

/// No cycle is late however long the machine is busy with other things.
constexpr Duration kTimeoutInLockstep = std::chrono::seconds(10);

}  // namespace

AnswerPacedRobot::AnswerPacedRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                                   WorkstationPort& port, rt::Arrival& commands,
                                   const MonotonicClock& clock, rt::ThreadSettings thread,
                                   record::RecordSink* sink, const LockstepOptions& options)
    : ThreadedRobot(config, std::move(plant), port, clock, std::move(thread), sink,
                    kTimeoutInLockstep),
      commands_(commands),
      options_(options),
      period_(std::chrono::duration_cast<Duration>(kCycle / options.pace.value_or(1))) {
  if (options.pace) RequireInRange("pace", *options.pace, 0.01, 100);
}

void AnswerPacedRobot::Run(const std::stop_token& stop) noexcept {
  DropCommands();
  robot().Begin();
  cycling_ = true;
  AdvanceToState();  // before any request: the same cycle in every session
  next_cycle_ = clock().Now();
  AwaitCycle(stop);
  while (!stop.stop_requested()) {
    Next();
    resend_ = clock().Now() + kResend;
    AwaitCycle(stop);
  }
  cycling_ = false;
}

void AnswerPacedRobot::Next() noexcept {
  if (is_paused()) {
    if (!WaitsForAnswers()) Repeat();
  } else if (IsFrozen()) {
    Repeat();
  } else {
    Advance();
    CountDown();
    waiting_since_ = clock().Now();
  }
}

void AnswerPacedRobot::Advance() noexcept {
  delivered_ = false;
  owes_cycle_ = false;
  bool ran_cycle = false;
  do {
    const Time due = robot().next_cycle();
    events().RunNext();
    ran_cycle = ran_cycle || robot().next_cycle() != due;
  } while (!delivered_ && !(ran_cycle && *events().NextTime() == robot().next_cycle()));
  if (robot().mode() != RobotMode::kMove) phase_ = Phase::kNone;
}

void AnswerPacedRobot::AdvanceToState() noexcept {
  Advance();
  for (int i = 0; i < kMostLost && !delivered_; ++i) Advance();
}

void AnswerPacedRobot::OnEvent(Time /*now*/, std::uint64_t /*message_id*/) noexcept {
  shown_ = robot().states().Take();
  shown_cycle_ = shown_.message_id;
  shown_.message_id += repeats_;
  answered_ = false;
  delivered_ = true;
  port().Deliver(shown_);
}

void AnswerPacedRobot::Repeat() noexcept {
  ++repeats_;
  ++shown_.message_id;
  port().Deliver(shown_);
}

bool AnswerPacedRobot::Step(std::uint64_t cycles) noexcept {
  std::uint64_t paused = 0;
  return cycles_allowed_.compare_exchange_strong(paused, cycles, std::memory_order_relaxed);
}

std::optional<std::uint64_t> AnswerPacedRobot::cycles_left() const noexcept {
  const std::uint64_t left = cycles_allowed_.load(std::memory_order_relaxed);
  return left == kUnlimited ? std::nullopt : std::optional(left);
}

bool AnswerPacedRobot::Reset(const std::optional<JointVector>& q) {
  const RobotConfig& config = std::as_const(*this).robot().config();
  const JointLimits& limits = config.onboard.limits;
  const JointVector start = q.value_or(config.q_start);
  for (std::size_t i = 0; i < kJoints; ++i) {
    RequireInRange(fmt::format("reset: joint {} (rad)", i + 1), start[i], limits.q_min[i],
                   limits.q_max[i]);
  }
  return BetweenMotions([&] {
    robot().Reset(start);
    OnGranted(Granted::kReset);
  });
}

bool AnswerPacedRobot::Save(const std::string& name) {
  const std::scoped_lock lock(keeping_);
  if (!snapshots_.contains(name) && snapshots_.size() >= kMostSnapshots) {
    throw InputError(fmt::format("snapshot: {} are kept already ({}); replace one of them",
                                 snapshots_.size(), NamesOf(snapshots_)));
  }
  bool is_running = true;
  const bool done = BetweenMotions([&] {
    is_running = cycling_;
    if (!is_running) return;
    snapshots_.insert_or_assign(name, Snapshot{events(), robot().Save(), owes_cycle_});
  });
  if (!is_running) throw InputError("snapshot: the robot's time does not run yet; try again");
  return done;
}

bool AnswerPacedRobot::Restore(const std::string& name) {
  const std::scoped_lock lock(keeping_);
  const auto found = snapshots_.find(name);
  if (found == snapshots_.end()) {
    throw InputError(
        fmt::format("restore: there is no snapshot \"{}\"; {}", name,
                    snapshots_.empty() ? "take one first" : "there are: " + NamesOf(snapshots_)));
  }
  const Snapshot& snapshot = found->second;
  return BetweenMotions([&] {
    events() = snapshot.events;
    robot().Restore(snapshot.robot);
    owes_cycle_ = snapshot.owes_cycle;
    phase_ = Phase::kNone;
    answered_ = false;
    const std::uint64_t shown_last = shown_.message_id;
    shown_ = robot().states().Take();
    shown_cycle_ = shown_.message_id;
    repeats_ = shown_last - shown_cycle_;  // INT's ids go back, those on the wire never do
    shown_.message_id = shown_last;
    Repeat();
  });
}

void AnswerPacedRobot::CountDown() noexcept {
  std::uint64_t left = cycles_allowed_.load(std::memory_order_relaxed);
  if (left == kUnlimited || left == 0) return;
  // Fails when Pause() or Resume() came in between, which then counts.
  cycles_allowed_.compare_exchange_strong(left, left - 1, std::memory_order_relaxed);
}

bool AnswerPacedRobot::IsFrozen() const noexcept {
  const bool is_stepped = cycles_left().value_or(0) > 0;
  if (!options_.freeze_when_idle || is_stepped || owes_cycle_) return false;
  if (phase_ != Phase::kNone && phase_ != Phase::kStarting) return false;
  const RobotMode mode = robot().mode();
  const bool settled =
      mode == RobotMode::kIdle || mode == RobotMode::kMove || mode == RobotMode::kReflex;
  const bool base_stands = robot().base() == nullptr || robot().base()->AtRest();
  return settled && base_stands && robot().AtRest() && !hand_is_busy();
}

void AnswerPacedRobot::OnGranted(Granted what) noexcept {
  const bool in_motion = robot().mode() == RobotMode::kMove;
  if (!in_motion) phase_ = Phase::kNone;  // the user stop may have ended a motion
  if (what == Granted::kStopMove) {
    if (in_motion) Stop();
    return;  // without a motion nothing changes
  }
  if (what == Granted::kMove) {
    phase_ = robot().is_asynchronous() ? Phase::kFree : Phase::kStarting;
    waiting_since_ = clock().Now();
  }
  if (!cycling_ || !IsFrozen()) return;
  owes_cycle_ = is_paused();
  if (owes_cycle_) return;
  AdvanceToState();
  if (phase_ == Phase::kStarting) next_cycle_ = clock().Now() + kToSecond;
}

void AnswerPacedRobot::Stop() noexcept {
  phase_ = Phase::kStopping;
  next_cycle_ = clock().Now();
}

void AnswerPacedRobot::TakeCommands() noexcept {
  while (port().Receive(received_)) {
    RobotCommand& command = received_.command;
    if (phase_ == Phase::kFree && command.message_id <= shown_.message_id) {
      command.message_id = shown_cycle_;
      robot().Send(command);
      continue;
    }
    // A duplicate would count or not, depending on the wall clock.
    if (command.message_id != shown_.message_id || answered_) continue;
    command.message_id = shown_cycle_;
    robot().Send(command);
    answered_ = true;
    const bool is_first =
        phase_ == Phase::kStarting && shown_.motion_generator_mode != MotionGeneratorMode::kIdle;
    if (!is_first) continue;
    phase_ = Phase::kAnswered;
    next_cycle_ = std::min(next_cycle_, clock().Now() + period_);  // no pause any more
  }
}

bool AnswerPacedRobot::IsDue(Time now) const noexcept {
  if (is_paused() && WaitsForAnswers()) return false;
  if (phase_ == Phase::kAnswered && !answered_ && delivered_) return false;
  return now >= next_cycle_ || (phase_ == Phase::kAnswered && !options_.pace);
}

void AnswerPacedRobot::GiveUpIfUnanswered(Time now) noexcept {
  const bool waits = phase_ == Phase::kStarting ? IsFrozen() : phase_ == Phase::kAnswered;
  if (is_paused()) waiting_since_ = now;
  if (waits && now >= waiting_since_ + options_.answer_timeout) {
    robot().StopMove();
    Stop();
    motions_given_up_.fetch_add(1, std::memory_order_relaxed);
  } else if (WaitsForAnswers() && (waits || is_paused()) && now >= resend_) {
    resend_ = now + kResend;
    port().Deliver(shown_);
  }
}

void AnswerPacedRobot::AwaitCycle(const std::stop_token& stop) noexcept {
  while (!stop.stop_requested()) {
    RunCalls();
    TakeCommands();
    const Time now = clock().Now();
    GiveUpIfUnanswered(now);
    if (IsDue(now)) break;
    const Time look = now + kLook;
    static_cast<void>(commands_.AwaitUntil(next_cycle_ > now ? std::min(next_cycle_, look) : look));
  }
  next_cycle_ = NextCycle(clock().Now());
}

Time AnswerPacedRobot::NextCycle(Time now) const noexcept {
  const Duration pause = phase_ == Phase::kStarting && IsFrozen() ? kToFurther : period_;
  const Duration behind = options_.pace ? kMostBehind : Duration::zero();
  return std::clamp(next_cycle_ + pause, now - behind, now + pause);
}

}  // namespace twin::robot

#include "twin/robot/realtime_robot.h"

#include <type_traits>
#include <utility>

#include "twin/core/check.h"
#include "twin/core/error.h"
#include "twin/rt/sleep.h"

namespace twin::robot {
namespace {

/// How long a request waits for the robot's thread: a thousand cycles.
constexpr Duration kPatience = std::chrono::seconds(1);

/// A thread of real-time priority that never sleeps starves the machine, until the kernel takes it
/// off its processor for 50 ms. One that has too much to do rests for so long after so much work.
constexpr Duration kLongestWork = 10 * kCycle;
constexpr Duration kRest = kCycle;

/// Lateness of a cycle that leaves the grid where it is: an ordinary wake-up. The robot whose cycle
/// begins later than that would have its next cycle, and the deadline of its next command, too
/// soon.
constexpr Duration kTolerated = kCycle / 4;

}  // namespace

RealtimeRobot::RealtimeRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                             const MonotonicClock& clock, rt::ThreadSettings thread,
                             rt::RecordSink* sink)
    : clock_(clock),
      thread_settings_(std::move(thread)),
      robot_(config, std::move(plant), events_, *this, sink),
      arrival_(clock),
      errands_(clock) {}

void RealtimeRobot::Begin() {
  TWIN_CHECK(!thread_.joinable());
  const std::scoped_lock lock(requests_);
  rt::StartedThread started =
      rt::StartThread(thread_settings_, [this](const std::stop_token& stop) { Run(stop); });
  thread_ = std::move(started.thread);
  notices_ = std::move(started.notices);
  running_ = true;
}

void RealtimeRobot::End() {
  const std::scoped_lock lock(requests_);
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  running_ = false;
}

template <typename Request>
std::invoke_result_t<Request> RealtimeRobot::Ask(Request request) const {
  const std::scoped_lock lock(requests_);
  if (!running_) return request();
  rt::CallErrand<Request> question(std::move(request));
  if (!errands_.Do(question, kPatience)) {
    throw RobotFault(
        "the robot's thread does not answer: it has not run for 1 s; this machine gives it no time "
        "(see panda-twin check)");
  }
  if constexpr (!std::is_void_v<std::invoke_result_t<Request>>) return question.answer();
}

MoveStatus RealtimeRobot::Move(const MotionModes& modes) {
  return Ask([&] { return robot_.Move(modes); });
}

void RealtimeRobot::StopMove() {
  Ask([&] { robot_.StopMove(); });
}

RecoveryStatus RealtimeRobot::AutomaticErrorRecovery() {
  return Ask([&] { return robot_.AutomaticErrorRecovery(); });
}

SetterStatus RealtimeRobot::Configure(const Setting& setting) {
  return Ask([&] { return robot_.Configure(setting); });
}

bool RealtimeRobot::Operate(PanelAction action) {
  return Ask([&] { return robot_.Operate(action); });
}

HandStart RealtimeRobot::StartHand(const HandCommand& command) {
  return Ask([&] { return robot_.StartHand(command); });
}

std::optional<HandResult> RealtimeRobot::HandOutcome(HandTicket ticket) const {
  return Ask([&] { return robot_.HandOutcome(ticket); });
}

HandState RealtimeRobot::hand_state() const {
  return Ask([&] { return robot_.hand_state(); });
}

RobotMode RealtimeRobot::mode() const {
  return Ask([&] { return robot_.mode(); });
}

LastMotion RealtimeRobot::last_motion() const {
  return Ask([&] { return robot_.last_motion(); });
}

void RealtimeRobot::Write(const RobotCommand& command) noexcept {
  const bool put = commands_.TryPushWith([&](Written& written) {
    written.command = command;
    written.at = clock_.Now();
  });
  if (!put) commands_lost_.fetch_add(1, std::memory_order_relaxed);
}

void RealtimeRobot::OnEvent(Time /*now*/, std::uint64_t /*message_id*/) noexcept {
  states_.Publish(robot_.states().Take());
  arrival_.Notify();
}

void RealtimeRobot::Run(const std::stop_token& stop) noexcept {
  while (commands_.TryPopWith([](const Written&) {})) {  // written before there was a robot
  }
  Time rested = clock_.Now();
  events_.AdvanceTo(rested);
  robot_.Begin();
  while (!stop.stop_requested()) {
    errands_.RunPending();
    const Time now = clock_.Now();
    Time wake = *events_.NextTime();  // there is always a next cycle
    if (wake <= now && now - rested > kLongestWork) wake = now + kRest;
    if (wake > now) {
      rt::SleepUntil(clock_, wake);
      rested = wake;
    }
    WorkOff(clock_.Now());
  }
}

void RealtimeRobot::WorkOff(Time now) noexcept {
  // As many as the ring holds: a writer that never pauses cannot keep the thread here.
  for (std::size_t i = 0; i < kCommands; ++i) {
    const bool any = commands_.TryPopWith([this](const Written& written) {
      RunEventsUntil(written.at);
      events_.AdvanceTo(written.at);
      robot_.Send(written.command);
    });
    if (!any) break;
  }
  RunEventsUntil(now);
}

void RealtimeRobot::RunEventsUntil(Time until) noexcept {
  for (auto next = events_.NextTime(); *next <= until; next = events_.NextTime()) {
    const Time now = clock_.Now();
    if (*next == robot_.next_cycle()) PostponeIfStalled(now);
    const Time due = robot_.next_cycle();
    events_.RunNext();
    const bool was_cycle = robot_.next_cycle() != due;
    if (!was_cycle) continue;
    lateness_.Add(now - due + postponed_);
    postponed_ = Duration::zero();
  }
}

void RealtimeRobot::PostponeIfStalled(Time now) noexcept {
  const Duration late = now - robot_.next_cycle();
  if (late <= kTolerated) return;
  robot_.Postpone(late);
  postponed_ += late;
  overruns_ += static_cast<std::uint64_t>(late / robot_.period());
}

}  // namespace twin::robot

#include "twin/robot/wall_clock_robot.h"

#include <algorithm>
#include <utility>

namespace twin::robot {
namespace {

/// A real-time thread that never sleeps starves the machine until the kernel suspends it for 50 ms.
/// An overloaded thread sleeps for kRest after kLongestWork.
constexpr Duration kLongestWork = 10 * kCycle;
constexpr Duration kRest = kCycle;

/// Lateness of a cycle that does not move the time grid: an ordinary wake-up. After a later start,
/// the next cycle and the deadline of its command would come too soon.
constexpr Duration kTolerated = kCycle / 4;

/// Commands taken per wake-up, so that a writer without pauses cannot keep the thread busy.
constexpr int kCommandsAtOnce = 64;

constexpr Duration kRequestTimeout = std::chrono::seconds(1);  // a thousand cycles

}  // namespace

WallClockRobot::WallClockRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                               WorkstationPort& port, const MonotonicClock& clock,
                               rt::ThreadSettings thread, record::RecordSink* sink)
    : ThreadedRobot(config, std::move(plant), port, clock, std::move(thread), sink,
                    kRequestTimeout),
      catch_up_(config.catch_up) {}

void WallClockRobot::OnEvent(Time /*now*/, std::uint64_t /*message_id*/) noexcept {
  const RobotState& state = robot().states().Take();
  // While it makes up for cycles, the workstation gets the last state only: it could not answer
  // the others in time, and would take each for a cycle of its own clock.
  const bool is_made_up_for =
      AllowedLateness() > Duration::zero() && robot().next_cycle() <= clock().Now();
  if (!is_made_up_for) port().Deliver(state);
}

void WallClockRobot::Run(const std::stop_token& stop) noexcept {
  DropCommands();
  Time rested = clock().Now();
  events().AdvanceTo(rested);
  robot().Begin();
  while (!stop.stop_requested()) {
    RunCalls();
    const Time now = clock().Now();
    Time wake = *events().NextTime();  // a next cycle always exists
    if (wake <= now && now - rested > kLongestWork) wake = now + kRest;
    if (wake > now) {
      SleepUntil(wake);
      rested = wake;
    }
    WorkOff(clock().Now());
  }
}

void WallClockRobot::WorkOff(Time now) noexcept {
  for (int i = 0; i < kCommandsAtOnce && port().Receive(received_); ++i) {
    RunEventsUntil(received_.at);
    events().AdvanceTo(received_.at);
    robot().Send(received_.command);
  }
  RunEventsUntil(now);
}

void WallClockRobot::RunEventsUntil(Time until) noexcept {
  for (auto next = events().NextTime(); *next <= until; next = events().NextTime()) {
    const Time now = clock().Now();
    if (*next == robot().next_cycle()) PostponeIfStalled(now);
    const Time due = robot().next_cycle();
    events().RunNext();
    const bool was_cycle = robot().next_cycle() != due;
    if (!was_cycle) continue;
    lateness_.Add(now - due + postponed_);
    overruns_ += static_cast<std::uint64_t>(postponed_ / robot().period());
    postponed_ = Duration::zero();
    if (shares_thread()) PostponeBy(clock().Now() - now);
  }
}

Duration WallClockRobot::AllowedLateness() noexcept {
  return std::max(catch_up_ - robot().lost_in_row() * robot().period(), Duration::zero());
}

void WallClockRobot::PostponeIfStalled(Time now) noexcept {
  PostponeBy(now - robot().next_cycle() - AllowedLateness());
}

void WallClockRobot::PostponeBy(Duration late) noexcept {
  if (late <= kTolerated) return;
  robot().Postpone(late);
  postponed_ += late;
}

}  // namespace twin::robot

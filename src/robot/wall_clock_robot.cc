#include "twin/robot/wall_clock_robot.h"

#include <utility>

#include "twin/rt/sleep.h"

namespace twin::robot {
namespace {

/// A thread of real-time priority that never sleeps starves the machine, until the kernel takes it
/// off its processor for 50 ms. One that has too much to do rests for so long after so much work.
constexpr Duration kLongestWork = 10 * kCycle;
constexpr Duration kRest = kCycle;

/// Lateness of a cycle that leaves the grid where it is: an ordinary wake-up. The robot whose cycle
/// begins later than that would have its next cycle, and the deadline of its next command, too
/// soon.
constexpr Duration kTolerated = kCycle / 4;

/// Commands that are taken at one wake-up: a writer that never pauses cannot keep the thread busy.
constexpr int kCommandsAtOnce = 64;

}  // namespace

WallClockRobot::WallClockRobot(const RobotConfig& config, std::unique_ptr<plant::Plant> plant,
                               WorkstationPort& port, const MonotonicClock& clock,
                               rt::ThreadSettings thread, rt::RecordSink* sink)
    : ThreadedRobot(config, std::move(plant), port, clock, std::move(thread), sink) {}

void WallClockRobot::OnEvent(Time /*now*/, std::uint64_t /*message_id*/) noexcept {
  port().Deliver(robot().states().Take());
}

void WallClockRobot::Run(const std::stop_token& stop) noexcept {
  DropCommands();
  Time rested = clock().Now();
  events().AdvanceTo(rested);
  robot().Begin();
  while (!stop.stop_requested()) {
    RunCalls();
    const Time now = clock().Now();
    Time wake = *events().NextTime();  // there is always a next cycle
    if (wake <= now && now - rested > kLongestWork) wake = now + kRest;
    if (wake > now) {
      rt::SleepUntil(clock(), wake);
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
  }
}

void WallClockRobot::PostponeIfStalled(Time now) noexcept {
  const Duration late = now - robot().next_cycle();
  if (late <= kTolerated) return;
  robot().Postpone(late);
  postponed_ += late;
}

}  // namespace twin::robot

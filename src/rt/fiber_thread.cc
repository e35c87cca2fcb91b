#include "twin/rt/fiber_thread.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "twin/core/error.h"
#include "twin/rt/fiber.h"
#include "twin/rt/host_time.h"

namespace twin::rt {
namespace {

thread_local FiberThread* running_thread = nullptr;

}  // namespace

struct FiberThread::Seat {
  explicit Seat(std::function<void()> body) : fiber(std::move(body)) {}

  Fiber fiber;
  std::int64_t wake_ns = 0;  ///< on CLOCK_MONOTONIC
  bool gives_way = false;    ///< it wakes once another function has run
};

FiberThread::FiberThread(ThreadSettings settings, std::function<void()> on_stop)
    : settings_(std::move(settings)), on_stop_(std::move(on_stop)) {}

FiberThread::~FiberThread() {
  Stop();
}

void FiberThread::Add(Body body) {
  TWIN_CHECK(!thread_.joinable());
  seats_.emplace_back([body = std::move(body), stop = stop_.get_token()] { body(stop); });
}

std::vector<std::string> FiberThread::Start() {
  TWIN_CHECK(!thread_.joinable());
  StartedThread started =
      StartThread(settings_, [this](const std::stop_token& stop) { Run(stop); });
  thread_ = std::move(started.thread);
  return std::move(started.notices);
}

void FiberThread::Stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void FiberThread::SleepUntil(const MonotonicClock& clock, Time deadline) noexcept {
  running_thread->running_->wake_ns = clock.MonotonicNs(deadline);
  Fiber::Yield();
}

void FiberThread::GiveWay() noexcept {
  running_thread->running_->gives_way = true;
  Fiber::Yield();
}

void FiberThread::Run(const std::stop_token& stop) noexcept {
  running_thread = this;
  while (std::ranges::any_of(seats_, [](const Seat& seat) { return !seat.fiber.ended(); })) {
    if (stop.stop_requested() && !stop_.stop_requested()) {
      if (on_stop_) on_stop_();
      stop_.request_stop();
    }
    RunDue();
    SleepUntilNext();
  }
}

void FiberThread::RunDue() noexcept {
  const std::int64_t now_ns = clock_.MonotonicNs(clock_.Now());
  for (Seat& seat : seats_) {
    if (!seat.gives_way && seat.wake_ns <= now_ns) Resume(seat);
  }
  for (Seat& seat : seats_) {
    if (std::exchange(seat.gives_way, false)) Resume(seat);
  }
}

void FiberThread::Resume(Seat& seat) noexcept {
  if (seat.fiber.ended()) return;
  running_ = &seat;
  seat.fiber.Resume();
}

void FiberThread::SleepUntilNext() noexcept {
  std::int64_t next_ns = clock_.MonotonicNs(clock_.Now() + kCycle);
  for (const Seat& seat : seats_) {
    if (!seat.fiber.ended() && !seat.gives_way) next_ns = std::min(next_ns, seat.wake_ns);
  }
  rt::SleepUntil(clock_, Time(Duration(next_ns - clock_.MonotonicNs(Time{}))));
}

}  // namespace twin::rt

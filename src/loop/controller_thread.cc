#include "loop/controller_thread.h"

#include <utility>

namespace twin::loop {
namespace {

constexpr Duration kWakePoll = std::chrono::milliseconds(50);

}  // namespace

ControllerThread::ControllerThread(const MonotonicClock& clock, ControllerLoop& loop,
                                   const MotionWatch& watch, rt::Signal& moving,
                                   const rt::ThreadSettings& settings)
    : clock_(clock), loop_(loop), watch_(watch), wake_(moving) {
  rt::StartedThread started =
      rt::StartThread(settings, [this](const std::stop_token& stop) { Run(stop); });
  thread_ = std::move(started.thread);
  notices_ = std::move(started.notices);
}

void ControllerThread::Stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  wake_.Notify();
  thread_.join();
}

void ControllerThread::Run(const std::stop_token& stop) noexcept {
  while (!watch_.moving()) {
    if (stop.stop_requested()) return;
    static_cast<void>(wake_.AwaitUntil(clock_.Now() + kWakePoll));
  }
  Time at = loop_.Start(clock_.Now());
  while (!stop.stop_requested() && !watch_.ended()) {
    if (wake_.AwaitUntil(at)) continue;  // stop requested
    const Time now = clock_.Now();
    at = loop_.OnWake(now) ? loop_.OnDone(clock_.Now()) : loop_.NextWake(now);
  }
}

}  // namespace twin::loop

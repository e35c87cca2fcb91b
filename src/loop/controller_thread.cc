#include "loop/controller_thread.h"

namespace twin::loop {
namespace {

constexpr Duration kLook = std::chrono::milliseconds(50);

}  // namespace

ControllerThread::ControllerThread(const MonotonicClock& clock, ControllerLoop& loop,
                                   const MotionWatch& watch, rt::Signal& moving,
                                   const rt::ThreadSettings& settings)
    : clock_(clock),
      loop_(loop),
      watch_(watch),
      wake_(moving),
      thread_([this, settings](const std::stop_token& stop) {
        // Whatever it is not permitted the communication thread, which asks for more, tells.
        static_cast<void>(rt::SetUpThisThread(settings));
        Run(stop);
      }) {}

void ControllerThread::Stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  wake_.Notify();
  thread_.join();
}

void ControllerThread::Run(const std::stop_token& stop) noexcept {
  while (!watch_.moving()) {
    if (stop.stop_requested()) return;
    static_cast<void>(wake_.AwaitUntil(clock_.Now() + kLook));
  }
  Time at = loop_.Start(clock_.Now());
  while (!stop.stop_requested() && !watch_.ended()) {
    if (wake_.AwaitUntil(at)) continue;  // told to stop
    const Time now = clock_.Now();
    at = loop_.OnWake(now) ? loop_.OnDone(clock_.Now()) : loop_.NextWake(now);
  }
}

}  // namespace twin::loop

#include "loop/communication_thread.h"

#include <algorithm>
#include <utility>

#include "twin/rt/host_time.h"

namespace twin::loop {
namespace {

/// Longest sleep between two checks for a stop request.
constexpr Duration kLook = std::chrono::milliseconds(50);
constexpr Duration kCallTimeout = std::chrono::seconds(1);

}  // namespace

CommunicationThread::CommunicationThread(const MonotonicClock& clock, CommunicationLoop& loop,
                                         backend::Backend& backend, rt::Arrival& arrival,
                                         MotionWatch& watch, rt::Signal& moving,
                                         const rt::ThreadSettings& settings)
    : clock_(clock),
      loop_(loop),
      backend_(backend),
      arrival_(arrival),
      watch_(watch),
      moving_(moving),
      calls_(clock) {
  rt::StartedThread started =
      rt::StartThread(settings, [this](const std::stop_token& stop) { Run(stop); });
  thread_ = std::move(started.thread);
  notices_ = std::move(started.notices);
}

bool CommunicationThread::Execute(rt::Call& call) {
  return calls_.Execute(call, kCallTimeout);
}

void CommunicationThread::Stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void CommunicationThread::Run(const std::stop_token& stop) noexcept {
  try {
    Communicate(stop);
  } catch (...) {
    // Ticks do not throw. If one does nevertheless, the arm must stop.
    StopMotion(LoopFailure::kException);
  }
}

void CommunicationThread::Communicate(const std::stop_token& stop) {
  Time next = loop_.Start(clock_.Now());
  while (!stop.stop_requested()) {
    calls_.RunPending();
    const Time now = clock_.Now();
    if (next > now) {
      rt::SleepUntil(clock_, std::min(next, now + kLook));
      if (next > now + kLook) continue;
    }
    switch (loop_.OnState()) {
      case CommunicationLoop::Outcome::kPending:
        static_cast<void>(arrival_.AwaitUntil(clock_.Now() + kLook));
        continue;
      case CommunicationLoop::Outcome::kLost: StopMotion(LoopFailure::kConnectionLost); return;
      case CommunicationLoop::Outcome::kComputing: break;
    }
    loop_.Write();
    next = loop_.OnDone(clock_.Now());
    states_.Publish(loop_.state());
    if (watch_.Observe(loop_.InMotion(), clock_.Now())) moving_.Notify();
    if (watch_.failure() != LoopFailure::kNone) continue;
    if (loop_.record().action == record::TickAction::kInvalid) {
      StopMotion(LoopFailure::kInvalidCommand);
    } else if (loop_.stopped_by_limit()) {
      StopMotion(LoopFailure::kLimit);
    }
  }
}

void CommunicationThread::StopMotion(LoopFailure failure) noexcept {
  try {
    backend_.Stop();
  } catch (...) {
    // The robot does not answer: without commands it stops by itself after 20 cycles.
  }
  watch_.Fail(failure);
}

}  // namespace twin::loop

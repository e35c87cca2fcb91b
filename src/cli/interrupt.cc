#include "cli/interrupt.h"

#include "twin/rt/child_process.h"

namespace twin::cli {
namespace {

// A signal handler can reach nothing but a global.
volatile bool interrupt_flag = false;

int guards = 0;  ///< that live; the first one's signals are all of them's

void OnSignal(int /*signal*/) {
  interrupt_flag = true;
}

}  // namespace

InterruptGuard::InterruptGuard() {
  if (guards++ > 0) return;
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], nullptr, &old_[i]);
  Rearm();
  rt::GiveUpWhen(&interrupt_flag);
}

InterruptGuard::~InterruptGuard() {
  if (--guards > 0) return;
  rt::GiveUpWhen(nullptr);
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &old_[i], nullptr);
}

void InterruptGuard::Rearm() const {
  interrupt_flag = false;
  struct sigaction action {};
  action.sa_handler = &OnSignal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    // nohup's children go on when the terminal is closed.
    const bool ignored = kSignals[i] == SIGHUP && old_[i].sa_handler == SIG_IGN;
    if (!ignored) sigaction(kSignals[i], &action, nullptr);
  }
}

bool WasInterrupted() noexcept {
  return interrupt_flag;
}

bool InterruptGuard::interrupted() const noexcept {
  return interrupt_flag;
}

const volatile bool* InterruptGuard::flag() const noexcept {
  return &interrupt_flag;
}

void InterruptGuard::Interrupt() const noexcept {
  interrupt_flag = true;
}

void InterruptGuard::ThrowIfInterrupted() const {
  if (interrupted()) throw Interrupted();
}

}  // namespace twin::cli

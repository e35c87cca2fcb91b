#include "cli/interrupt.h"

namespace twin::cli {
namespace {

// A signal handler can reach nothing but a global.
volatile bool interrupt_flag = false;

void OnSignal(int /*signal*/) {
  interrupt_flag = true;
}

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupt_flag = false;
  struct sigaction action {};
  action.sa_handler = &OnSignal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

InterruptGuard::~InterruptGuard() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
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

#include "twin/rt/call_mailbox.h"

namespace twin::rt {

bool CallMailbox::Execute(Call& call, Duration timeout) {
  // Release: publishes the contents of the call with its address.
  slot_.store(&call, std::memory_order_release);
  if (done_.AwaitUntil(clock_.Now() + timeout)) return true;
  Call* expected = &call;
  // Relaxed suffices: no other thread has used the call.
  if (slot_.compare_exchange_strong(expected, nullptr, std::memory_order_relaxed)) return false;
  while (!done_.AwaitUntil(Time::max())) {  // it has started and uses `call` until done
  }
  return true;
}

void CallMailbox::RunPending() noexcept {
  // Usually empty: a load is cheaper than an exchange.
  if (slot_.load(std::memory_order_relaxed) == nullptr) return;
  Call* call = slot_.exchange(nullptr, std::memory_order_acquire);
  if (call == nullptr) return;  // taken back by the requester
  call->Run();
  done_.Notify();
}

}  // namespace twin::rt

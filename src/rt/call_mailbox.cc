#include "twin/rt/call_mailbox.h"

namespace twin::rt {

bool CallMailbox::Execute(Call& call, Duration timeout) {
  // Release: what the call carries travels with its address.
  slot_.store(&call, std::memory_order_release);
  if (done_.AwaitUntil(clock_.Now() + timeout)) return true;
  Call* expected = &call;
  // Acquire-release is not needed to take back what nobody has touched.
  if (slot_.compare_exchange_strong(expected, nullptr, std::memory_order_relaxed)) return false;
  while (!done_.AwaitUntil(Time::max())) {  // it has begun, and uses `call` until it is done
  }
  return true;
}

void CallMailbox::RunPending() noexcept {
  // Nearly always empty: looking costs less than exchanging.
  if (slot_.load(std::memory_order_relaxed) == nullptr) return;
  Call* call = slot_.exchange(nullptr, std::memory_order_acquire);
  if (call == nullptr) return;  // taken back meanwhile
  call->Run();
  done_.Notify();
}

}  // namespace twin::rt

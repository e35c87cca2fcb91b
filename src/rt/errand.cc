#include "twin/rt/errand.h"

namespace twin::rt {

bool ErrandBox::Do(Errand& errand, Duration patience) {
  // Release: what the errand carries travels with its address.
  slot_.store(&errand, std::memory_order_release);
  if (done_.AwaitUntil(clock_.Now() + patience)) return true;
  Errand* expected = &errand;
  // Acquire-release is not needed to take back what nobody has touched.
  if (slot_.compare_exchange_strong(expected, nullptr, std::memory_order_relaxed)) return false;
  while (!done_.AwaitUntil(Time::max())) {  // it has begun, and uses `errand` until it is done
  }
  return true;
}

void ErrandBox::RunPending() noexcept {
  // Nearly always empty: looking costs less than exchanging.
  if (slot_.load(std::memory_order_relaxed) == nullptr) return;
  Errand* errand = slot_.exchange(nullptr, std::memory_order_acquire);
  if (errand == nullptr) return;  // taken back meanwhile
  errand->Run();
  done_.Notify();
}

}  // namespace twin::rt

#include <cstdio>
#include <filesystem>

#include "twin/core/random.h"
#include "twin/rt/event_queue.h"

namespace {

class Counter final : public twin::rt::EventHandler {
 public:
  void OnEvent(twin::Time, std::uint64_t token) noexcept override { sum += token; }
  std::uint64_t sum = 0;
};

}  // namespace

// Runs a little of two areas, and finds the installed models.
int main() {
  twin::rt::EventQueue queue;
  Counter counter;
  queue.Schedule(queue.Now() + twin::kCycle, twin::rt::EventOrder::kOnboardCycle, counter, 42);
  while (queue.RunNext()) {
  }
  const auto bits = twin::Random(0, twin::RandomStream{0}).Bits(0);
  const bool models = std::filesystem::is_directory(MODELS);
  std::printf("sum %llu, bits %08x, models %s\n", static_cast<unsigned long long>(counter.sum),
              bits[0], models ? "found" : "missing");
  return counter.sum == 42 && bits[0] == 0x6627e8d5 && models ? 0 : 1;
}

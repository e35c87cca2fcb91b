#include <benchmark/benchmark.h>

#include "twin/core/random.h"
#include "twin/rt/event_queue.h"
#include "twin/rt/spsc_ring.h"

namespace twin::rt {
namespace {

/// Keeps the queue at its length: every event schedules its successor.
class Successor final : public EventHandler {
 public:
  explicit Successor(EventQueue& queue) : queue_(queue) {}
  void OnEvent(Time now, std::uint64_t token) noexcept override {
    queue_.Schedule(now + kCycle, EventOrder::kOnboardCycle, *this, token);
  }

 private:
  EventQueue& queue_;
};

/// One event in and one out, with as many pending as the argument says; lockstep has about ten.
void RunOneEvent(benchmark::State& state) {
  EventQueue queue;
  Successor successor(queue);
  for (std::int64_t i = 0; i < state.range(0); ++i) {
    queue.Schedule(Time(Duration(i)), EventOrder::kOnboardCycle, successor);
  }
  for (auto _ : state) benchmark::DoNotOptimize(queue.RunNext());
}
BENCHMARK(RunOneEvent)->Arg(8)->Arg(64)->Arg(1024);

void DrawNormal(benchmark::State& state) {
  const Random random(1, RandomStream::kTest);
  std::uint64_t tick = 0;
  for (auto _ : state) benchmark::DoNotOptimize(random.Normal(tick++));
}
BENCHMARK(DrawNormal);

void PushAndPop(benchmark::State& state) {
  SpscRing<std::uint64_t> ring(64);
  std::uint64_t sum = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(ring.TryPush(1));
    ring.TryPopWith([&sum](const std::uint64_t& value) { sum += value; });
  }
  benchmark::DoNotOptimize(sum);
}
BENCHMARK(PushAndPop);

}  // namespace
}  // namespace twin::rt

// What it costs to write a robot state as a datagram and to read it again, as multiples of copying
// the same bytes twice, measured in one run; the command likewise. Prints and does not gate.

#include <benchmark/benchmark.h>

#include <cstring>

#include "fci/random_messages.h"
#include "twin/core/clock.h"
#include "twin/fci/datagrams.h"

namespace twin::fci {
namespace {

constexpr int kBatch = 1000;

template <typename Encoded>
void CopyTwice(Encoded& from, Encoded& to) {
  std::memcpy(to.data(), from.data(), from.size());
  benchmark::ClobberMemory();
  std::memcpy(from.data(), to.data(), to.size());
  benchmark::ClobberMemory();
}

template <typename Encoded, typename Datagram>
void EncodeAndDecode(const Datagram& datagram, Encoded& bytes, Datagram& back) {
  Encode(datagram, bytes);
  benchmark::ClobberMemory();
  benchmark::DoNotOptimize(Decode(bytes, back));
  benchmark::ClobberMemory();
}

/// Seconds of the run's clock that `work` takes.
template <typename Work>
double SecondsOf(const MonotonicClock& clock, Work work) {
  const Time start = clock.Now();
  for (int i = 0; i < kBatch; ++i) work();
  return ToSeconds(clock.Now() - start);
}

/// Interleaves batches of both, so that a busy machine slows them alike.
template <typename Encoded, typename Datagram>
void OverMemcpy(benchmark::State& state, const Datagram& datagram) {
  const MonotonicClock clock;
  Encoded bytes{};
  Encoded copy{};
  Datagram back;
  double coding = 0;
  double copying = 0;
  for (auto _ : state) {
    coding += SecondsOf(clock, [&] { EncodeAndDecode(datagram, bytes, back); });
    copying += SecondsOf(clock, [&] { CopyTwice(bytes, copy); });
  }
  const auto runs = static_cast<double>(state.iterations()) * kBatch;
  state.counters["encode_decode_ns"] = 1e9 * coding / runs;
  state.counters["memcpy_ns"] = 1e9 * copying / runs;
  state.counters["ratio"] = coding / copying;
}

void RobotStateOverMemcpy(benchmark::State& state) {
  OverMemcpy<StateBytes>(state, RandomMessages(1).State());
}
BENCHMARK(RobotStateOverMemcpy);

void RobotCommandOverMemcpy(benchmark::State& state) {
  OverMemcpy<CommandBytes>(state, RandomMessages(1).Command());
}
BENCHMARK(RobotCommandOverMemcpy);

}  // namespace
}  // namespace twin::fci

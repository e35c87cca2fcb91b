// What the viability filter costs, seven joints, by n: behind a generator, where it is idle, and
// with every joint at its border in every cycle. Counters: microseconds, median and 99.9th
// percentile, of single calls. What is hoped for: at most 1 us in the median for n >= 10, and at
// most 40 us in 99.9 % of the calls with all joints saturated.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/panda_limits.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference {
namespace {

/// A reference that the filter's own commands move. @param wish  jerk of a joint, rad/s^3.
template <typename Wish>
void Measure(benchmark::State& state, Wish wish) {
  constexpr double kT = kCycleSeconds;
  const ViabilityFilter filter(test::PandaLimits(), static_cast<int>(state.range(0)));
  JointVector q{0, 0, 0, -1.5, 0, 1.9, 0};
  JointVector dq{};
  JointVector ddq{};
  std::vector<double> costs;
  std::uint64_t cycle = 0;
  for (auto _ : state) {
    JointVector q_c{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      q_c[i] = ViableAxis::Step({q[i], dq[i], ddq[i]}, wish(i, cycle)).q;
    }
    const auto begin = std::chrono::steady_clock::now();
    const ViabilityFilter::Outcome outcome = filter.Next(q, dq, ddq, q_c);
    const auto end = std::chrono::steady_clock::now();
    costs.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
    state.SetIterationTime(1e-6 * costs.back());
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double v = (outcome.q_c[i] - q[i]) / kT;
      ddq[i] = (v - dq[i]) / kT;
      dq[i] = v;
      q[i] = outcome.q_c[i];
    }
    ++cycle;
  }
  std::sort(costs.begin(), costs.end());
  state.counters["median_us"] = costs[costs.size() / 2];
  state.counters["p99.9_us"] = costs[costs.size() * 999 / 1000];
}

void Idle(benchmark::State& state) {
  Measure(state, [](std::size_t joint, std::uint64_t cycle) {
    const double period = 800 + 50 * static_cast<double>(joint);  // cycles
    return 100 * std::sin(6.28 * static_cast<double>(cycle) / period);
  });
}
void Saturated(benchmark::State& state) {
  Measure(state,
          [](std::size_t, std::uint64_t cycle) { return cycle / 400 % 2 == 0 ? 1e6 : -1e6; });
}
BENCHMARK(Idle)->Arg(0)->Arg(3)->Arg(10)->Arg(19)->UseManualTime()->Iterations(200000);
BENCHMARK(Saturated)->Arg(0)->Arg(3)->Arg(10)->Arg(19)->UseManualTime()->Iterations(100000);

}  // namespace
}  // namespace twin::reference

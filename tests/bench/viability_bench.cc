// What the viability filter costs, seven joints, by n: behind a generator, where it is idle, and
// with every joint at its border in every cycle. Counters: microseconds, median, 99th and 99.9th
// percentile, of single calls. Late: with so many commands in flight and n = 19, from joints that
// rest inside the range, or a little below its end.
//
// Limits are shares of a yardstick measured in the same process, a thousand dependent steps x = a x
// + b, of some 2.7 us on a 3 GHz processor; of the slowest case of each benchmark, see kLimits.
// Exits with 1 when one is too large: absolute times of a shared machine say little, ratios hold.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "support/panda_limits.h"
#include "twin/core/clock.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/reference/viability_filter.h"
#include "twin/reference/viability_in_flight.h"

namespace twin::reference {
namespace {

const JointVector kStart{0, 0, 0, -1.5, 0, 1.9, 0};

/// Costs of single calls, microseconds.
class Costs {
 public:
  template <typename Call>
  auto Of(benchmark::State& state, Call call) {
    const Time begin = clock_.Now();
    const auto outcome = call();
    costs_.push_back(1e6 * ToSeconds(clock_.Now() - begin));
    state.SetIterationTime(1e-6 * costs_.back());
    return outcome;
  }
  void Report(benchmark::State& state) {
    std::sort(costs_.begin(), costs_.end());
    state.counters["median_us"] = costs_[costs_.size() / 2];
    state.counters["p99_us"] = costs_[costs_.size() * 99 / 100];
    state.counters["p99.9_us"] = costs_[costs_.size() * 999 / 1000];
  }

 private:
  const MonotonicClock clock_;
  std::vector<double> costs_;
};

/// A reference that the filter's own commands move. @param wish  of a joint: (joint, its state,
/// cycle), rad.
template <typename Wish>
void Measure(benchmark::State& state, Wish wish) {
  constexpr double kT = kCycleSeconds;
  const ViabilityFilter filter(test::PandaLimits(), static_cast<int>(state.range(0)));
  JointVector q = kStart;
  JointVector dq{};
  JointVector ddq{};
  Costs costs;
  std::uint64_t cycle = 0;
  std::uint64_t changed = 0;
  for (auto _ : state) {
    JointVector q_c{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      q_c[i] = wish(i, AxisState{q[i], dq[i], ddq[i]}, cycle);
    }
    const auto outcome = costs.Of(state, [&] { return filter.Next(q, dq, ddq, q_c); });
    changed += outcome.any() ? 1 : 0;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double v = (outcome.q_c[i] - q[i]) / kT;
      ddq[i] = (v - dq[i]) / kT;
      dq[i] = v;
      q[i] = outcome.q_c[i];
    }
    ++cycle;
  }
  costs.Report(state);
  state.counters["changed"] = static_cast<double>(changed) / static_cast<double>(cycle);
}

/// A late client with range(0) commands in flight; each of them moves joints at rest by a jerk of
/// a hundredth of the limit, whether it arrives or not. @param below  rad, how far the
/// joints are from their upper limits. @param wish  share of the greatest jerk.
void MeasureLate(benchmark::State& state, double below, double wish) {
  const ViabilityInFlight filter(test::PandaLimits(), static_cast<int>(state.range(0)));
  const JointLimits limits = test::PandaLimits();
  JointVector q{};
  JointVector wished{};
  std::array<InFlight, ViabilityInFlight::kMostInFlight> since{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    q[i] = limits.q_max[i] - below;
    AxisState x{.q = q[i]};
    for (InFlight& command : since) {
      x = ViableAxis::Step(x, 0.01 * limits.dddq_max[i]);
      command.sent = true;
      command.c[i] = x.q;
    }
    wished[i] = ViableAxis::Step(x, wish * limits.dddq_max[i]).q;
  }
  const auto in_flight = std::span(since).first(static_cast<std::size_t>(state.range(0)));
  Costs costs;
  std::uint64_t sent = 0;
  for (auto _ : state) {
    const auto outcome = costs.Of(state, [&] { return filter.Next(q, {}, {}, in_flight, wished); });
    sent += outcome.send ? 1 : 0;
  }
  costs.Report(state);
  state.counters["sent"] = static_cast<double>(sent) / static_cast<double>(state.iterations());
}

/// To and fro, up to 1 rad/s; the way begins without a jump of the acceleration.
void Idle(benchmark::State& state) {
  Measure(state, [](std::size_t joint, const AxisState&, std::uint64_t cycle) {
    const double period = 2000 + 100 * static_cast<double>(joint);  // cycles
    const double lift = 1 - std::cos(6.283185307 * static_cast<double>(cycle + 1) / period);
    return kStart[joint] + 0.12 * lift * lift;
  });
}
void Saturated(benchmark::State& state) {
  Measure(state, [](std::size_t, const AxisState& x, std::uint64_t cycle) {
    return ViableAxis::Step(x, cycle / 400 % 2 == 0 ? 1e6 : -1e6).q;
  });
}
void LateIdle(benchmark::State& state) {
  MeasureLate(state, 1, 0.01);
}
void LateSaturated(benchmark::State& state) {
  MeasureLate(state, 3e-4, 0.5);
}

void Yardstick(benchmark::State& state) {
  Costs costs;
  double x = 0.5;
  for (auto _ : state) {
    x = costs.Of(state, [x] {
      double y = x;
      for (int i = 0; i < 1000; ++i) y = 0.999 * y + 1e-3;
      return y;
    });
  }
  benchmark::DoNotOptimize(x);
  costs.Report(state);
}

BENCHMARK(Yardstick)->UseManualTime()->Iterations(100000);
BENCHMARK(Idle)->Arg(0)->Arg(3)->Arg(10)->Arg(19)->UseManualTime()->Iterations(200000);
BENCHMARK(Saturated)->Arg(0)->Arg(3)->Arg(10)->Arg(19)->UseManualTime()->Iterations(100000);
BENCHMARK(LateIdle)->Arg(1)->Arg(2)->UseManualTime()->Iterations(100000);
BENCHMARK(LateSaturated)->Arg(1)->Arg(2)->UseManualTime()->Iterations(50000);

/// Prints as usual and keeps the counters of each benchmark; of several cases the greatest.
class Reporter final : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      for (const auto& [name, counter] : run.counters) {
        double& greatest = counters[run.run_name.function_name][name];
        greatest = std::max(greatest, counter.value);
      }
    }
  }
  std::map<std::string, std::map<std::string, double>> counters;
};

struct Limit {
  const char* benchmark;
  const char* counter;
  double most;  ///< as a share of the yardstick's median
};
/// Some twice what was measured on two loaded processors of 2.6 GHz.
constexpr std::array kLimits{
    Limit{"Idle", "median_us", 1},          Limit{"Saturated", "median_us", 3},
    Limit{"Saturated", "p99_us", 80},       Limit{"LateIdle", "median_us", 1},
    Limit{"LateSaturated", "median_us", 8},
};

int Verdict(const Reporter& reporter) {
  const double yardstick = reporter.counters.at("Yardstick").at("median_us");
  bool good = true;
  for (const Limit& limit : kLimits) {
    const double share = reporter.counters.at(limit.benchmark).at(limit.counter) / yardstick;
    std::printf("%-13s %-9s %6.2f (at most %.0f)\n", limit.benchmark, limit.counter, share,
                limit.most);
    good = good && share <= limit.most;
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace twin::reference

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  twin::reference::Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  return twin::reference::Verdict(reporter);
}

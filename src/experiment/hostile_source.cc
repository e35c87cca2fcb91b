#include "experiment/hostile_source.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "experiment/chain_bench.h"
#include "experiment/convergence.h"
#include "twin/core/time.h"
#include "twin/reference/viability_filter.h"

namespace twin::experiment {
namespace {

constexpr int kCycles = 12'000;

/// The source's position. Beyond the range of +-2.9 rad, at up to 2.7 rad/s.
double WishedAt(double t) {
  constexpr double kAmplitude = 3.2;  // rad
  constexpr double kOmega = 0.85;     // rad/s
  constexpr double kJumpAt = 9;       // s
  constexpr double kJump = -1;        // rad
  return kAmplitude * std::sin(kOmega * t) + (t < kJumpAt ? 0 : kJump);
}

/// In the last of every three seconds one command of twenty arrives.
bool IsLost(int cycle) {
  constexpr int kOneOf = reference::ViabilityFilter::kLostByDefault + 1;
  return cycle % 3000 >= 2000 && cycle % kOneOf != 0;
}

/// What broke a limit, of all cycles.
struct Breaches {
  int cycles = 0;
  double largest_share = 0;
  double beyond_range = 0;  ///< rad; <= 0: within
};

Breaches BreachesOf(const std::vector<HostileCycle>& cycles, const JointLimits& limits) {
  // The robot's own checks leave that much to rounding.
  constexpr double kRounding = 1e-9;
  Breaches breaches{.beyond_range = -std::numeric_limits<double>::infinity()};
  for (const HostileCycle& cycle : cycles) {
    const double beyond = std::max(limits.q_min[0] - cycle.q_d, cycle.q_d - limits.q_max[0]);
    breaches.beyond_range = std::max(breaches.beyond_range, beyond);
    breaches.largest_share = std::max(breaches.largest_share, cycle.share);
    breaches.cycles += cycle.share > 1 + kRounding || beyond > 0 ? 1 : 0;
  }
  return breaches;
}

Figure CyclesFigure(const std::vector<HostileCycle>& cycles, const JointLimits& limits) {
  constexpr std::size_t kEvery = 4;
  Figure figure{
      .id = "hostile",
      .columns =
          "t [s],wished [rad],q_d [rad],dq_d [rad/s],share [-],margin [-],kept "
          "back [-],lost [-]",
      .values = {
          {"q_min", limits.q_min[0]}, {"q_max", limits.q_max[0]}, {"dq_max", limits.dq_max[0]}}};
  for (std::size_t k = 0; k < cycles.size(); k += kEvery) {
    const HostileCycle& c = cycles[k];
    figure.rows.push_back({c.t, c.wished, c.q_d, c.dq_d, c.share, c.margin, c.kept_back ? 1.0 : 0.0,
                           c.is_lost ? 1.0 : 0.0});
  }
  return figure;
}

}  // namespace

std::vector<HostileCycle> RunHostileSource(const loop::TickConfig& tick,
                                           const JointLimits& limits) {
  ChainBench bench(tick, MiddleOf(limits));
  std::vector<HostileCycle> cycles;
  cycles.reserve(kCycles);
  for (int k = 0; k < kCycles; ++k) {
    const double t = k * kCycleSeconds;
    const double wished = WishedAt(t);
    const double dq = (wished - WishedAt(t - kCycleSeconds)) / kCycleSeconds;
    const bool is_lost = IsLost(k);
    is_lost ? bench.StepLost(wished, dq, true) : bench.Step(wished, dq, true);
    cycles.push_back({.t = t,
                      .wished = wished,
                      .q_d = bench.q_d(),
                      .dq_d = bench.dq_d(),
                      .share = bench.LargestShare(limits),
                      .margin = bench.margin().value_or(0),
                      .kept_back = bench.kept_back(),
                      .is_lost = is_lost});
  }
  return cycles;
}

void AddHostileSource(const scenario::RobotData& robot, Findings& findings) {
  const std::vector<ConvergenceWay> ways = ConvergenceWays(robot);
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const std::vector<HostileCycle> cycles = RunHostileSource(ways[w].tick, robot.limits);
    const Breaches breaches = BreachesOf(cycles, robot.limits);
    const std::string name =
        fmt::format("a source that asks for too much, 19 of 20 lost at times, {}: ", ways[w].name);
    const bool is_ours = w == 0;
    findings.comparisons.push_back(
        {.quantity = name + "cycles beyond a limit",
         .ours = static_cast<double>(breaches.cycles),
         .demand = is_ours ? "none" : "",
         .verdict = is_ours ? Judge(breaches.cycles == 0) : Verdict::kReported});
    findings.comparisons.push_back(
        {.quantity = name + "largest share of a limit", .ours = breaches.largest_share});
    findings.comparisons.push_back({.quantity = name + "beyond the range by at most",
                                    .unit = "rad",
                                    .ours = std::max(0.0, breaches.beyond_range)});
    if (is_ours) findings.figures.push_back(CyclesFigure(cycles, robot.limits));
  }
}

}  // namespace twin::experiment

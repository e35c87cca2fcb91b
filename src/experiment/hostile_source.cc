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
#include "twin/report/chart.h"

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

report::ChartCurve Curve(std::string name, std::size_t series,
                         const std::vector<HostileCycle>& cycles, double HostileCycle::*field) {
  report::ChartCurve curve{.name = std::move(name), .colour = report::colour::kSeries.at(series)};
  for (const HostileCycle& cycle : cycles) {
    curve.x.push_back(cycle.t);
    curve.y.push_back(cycle.*field);
  }
  return curve;
}

report::ChartCurve Limit(std::string name, double value) {
  return {.name = std::move(name),
          .colour = report::colour::kLimit,
          .style = report::ChartCurve::Style::kDashed,
          .x = {0, kCycles * kCycleSeconds},
          .y = {value, value}};
}

/// Cycles of a kind, on a line.
template <class Condition>
report::ChartCurve Marks(std::string name, std::size_t series, double line,
                         const std::vector<HostileCycle>& cycles, const Condition& condition) {
  report::ChartCurve curve{.name = std::move(name),
                           .colour = report::colour::kSeries.at(series),
                           .style = report::ChartCurve::Style::kPoints};
  for (const HostileCycle& cycle : cycles) {
    if (!condition(cycle)) continue;
    curve.x.push_back(cycle.t);
    curve.y.push_back(line);
  }
  return curve;
}

Figure Draw(const std::vector<HostileCycle>& cycles, const JointLimits& limits) {
  constexpr std::size_t kEvery = 4;
  Figure figure{.id = "hostile",
                .title = "A source that asks for too much, joint 1",
                .what =
                    "It swings beyond the range, faster than the joint may go, and jumps at 9 s; "
                    "in the marked spans 19 of 20 commands are lost. The filter gives as much "
                    "as can be given, and not one limit is broken. What is lost lowers the "
                    "margin, even below zero: it has been reckoned with already.",
                .svg = {},
                .columns =
                    "t [s],wished [rad],q_d [rad],dq_d [rad/s],share [-],margin [-],kept "
                    "back [-],lost [-]",
                .rows = {}};
  for (std::size_t k = 0; k < cycles.size(); k += kEvery) {
    const HostileCycle& c = cycles[k];
    figure.rows.push_back({c.t, c.wished, c.q_d, c.dq_d, c.share, c.margin, c.kept_back ? 1.0 : 0.0,
                           c.is_lost ? 1.0 : 0.0});
  }
  report::ChartPanel position{
      .title = "position",
      .y_label = "q_d [rad]",
      .curves = {Curve("wished", 1, cycles, &HostileCycle::wished),
                 Curve("q_d", 0, cycles, &HostileCycle::q_d), Limit("limit", limits.q_max[0]),
                 Limit("", limits.q_min[0])}};
  report::ChartPanel velocity{
      .title = "velocity",
      .y_label = "dq_d [rad/s]",
      .curves = {Curve("", 0, cycles, &HostileCycle::dq_d), Limit("", limits.dq_max[0]),
                 Limit("", -limits.dq_max[0])}};
  constexpr double kKeptBackLine = -0.06;
  constexpr double kLostLine = -0.12;
  report::ChartPanel margin{
      .title = "margin to the border of the viable set",
      .x_label = "t [s]",
      .y_label = "margin",
      .y_range = {{-0.18, 0.5}},
      .curves = {Curve("", 0, cycles, &HostileCycle::margin),
                 Marks("kept back", 2, kKeptBackLine, cycles,
                       [](const HostileCycle& cycle) { return cycle.kept_back; }),
                 Marks("lost", 4, kLostLine, cycles,
                       [](const HostileCycle& cycle) { return cycle.is_lost; })}};
  figure.svg =
      report::DrawChart({.title = figure.title,
                         .width = 1000,
                         .panel_height = 250,
                         .panels = {std::move(position), std::move(velocity), std::move(margin)}});
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
    if (is_ours) findings.figures.push_back(Draw(cycles, robot.limits));
  }
}

}  // namespace twin::experiment

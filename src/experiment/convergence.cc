#include "experiment/convergence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "experiment/chain_bench.h"
#include "experiment/stream.h"
#include "experiment/viable_set.h"
#include "twin/core/time.h"
#include "twin/reference/resampler.h"
#include "twin/reference/viability_filter.h"

namespace twin::experiment {
namespace {

constexpr int kCycles = 20'000;
constexpr double kClose = 1e-4;                            ///< rad
constexpr std::array<double, 3> kOffsets{0.01, 0.1, 0.5};  ///< rad
constexpr double kDrawnOffset = 0.1;
constexpr std::size_t kOurs = 0;

/// The source's joint 1.
struct Source {
  double middle = 0;  ///< rad
  bool moves = false;

  static constexpr double kAmplitude = 0.5;  ///< rad
  static constexpr double kOmega = 1.25;     ///< rad/s

  [[nodiscard]] double q(double t) const {
    return moves ? middle + kAmplitude * std::sin(kOmega * t) : middle;
  }
  [[nodiscard]] double dq(double t) const {
    return moves ? kAmplitude * kOmega * std::cos(kOmega * t) : 0;
  }
  /// As a deposit has it: the mean since the one before.
  [[nodiscard]] double deposited_dq(double t) const {
    return (q(t) - q(t - kCycleSeconds)) / kCycleSeconds;
  }
};

/// The delay that leaves the least squares over the last quarter, s.
double LagOf(const std::vector<double>& q_d, const Source& source) {
  if (!source.moves) return 0;
  constexpr int kSteps = 4;  // Gauss and Newton's
  double lag = 0;
  for (int step = 0; step < kSteps; ++step) {
    double product = 0;
    double square = 0;
    for (std::size_t k = q_d.size() * 3 / 4; k < q_d.size(); ++k) {
      const double t = static_cast<double>(k) * kCycleSeconds - lag;
      product += (source.q(t) - q_d[k]) * source.dq(t);
      square += source.dq(t) * source.dq(t);
    }
    lag = std::clamp(lag + product / square, -0.1, 0.1);
  }
  return lag;
}

/// Since the last cycle that was not close, s; not a number when that is in the last quarter.
double TimeUntilClose(const std::vector<double>& errors) {
  std::size_t k = errors.size();
  while (k > 0 && std::abs(errors[k - 1]) <= kClose) --k;
  if (k > errors.size() * 3 / 4) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(k) * kCycleSeconds;
}

std::string CaseName(double offset, bool moves) {
  return fmt::format("{} rad behind a source that {}", offset, moves ? "moves" : "stands");
}

void Compare(const std::vector<ConvergenceWay>& ways, const std::vector<Convergence>& all,
             double offset, bool moves, Findings& findings) {
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const bool is_ours = w == kOurs;
    if (!is_ours && offset != kDrawnOffset) continue;  // theirs of one offset are enough
    const std::string name = fmt::format("{}, {}: ", CaseName(offset, moves), ways[w].name);
    const auto add = [&](const char* what, const char* unit, double ours, const char* demand,
                         bool met) {
      findings.comparisons.push_back({.quantity = name + what,
                                      .unit = unit,
                                      .ours = ours,
                                      .demand = is_ours ? demand : "",
                                      .verdict = is_ours ? Judge(met) : Verdict::kReported});
    };
    const Convergence& one = all[w];
    const bool is_sooner = one.time_s < all[1].time_s || std::isnan(all[1].time_s);
    add("until within 0.1 mrad for good", "s", one.time_s, "sooner than with lambda = 1e-3",
        is_sooner);
    add("overshoot", "%", 100 * one.overshoot, "at most 0.1 % of the offset",
        one.overshoot <= 1e-3);
    add("largest share of a limit", "", one.share, "at most 1", one.share <= 1);
  }
}

/// How much longer ours takes to a source that stands than the fastest way behind the same filter.
void CompareWithFastest(const Convergence& ours, const JointLimits& limits, double offset,
                        Findings& findings) {
  const double fastest = RestToRestTime(reference::BoundsOf(limits, 0),
                                        reference::ViabilityFilter::kLostByDefault, offset, kClose);
  findings.comparisons.push_back(
      {.quantity = fmt::format("{}, saturated correction: time over that of the fastest way",
                               CaseName(offset, false)),
       .ours = ours.time_s / fastest});
}

/// What is added to the lag of an admissible source: nothing but the resampler's.
void CompareLags(const std::vector<ConvergenceWay>& ways, const std::vector<Convergence>& moving,
                 Findings& findings) {
  const double resampling = reference::Resampler(1 / kCycleSeconds).lag_s();
  for (std::size_t w = 0; w < ways.size(); ++w) {
    Comparison comparison{
        .quantity = fmt::format("lag behind an admissible source, {}", ways[w].name),
        .unit = "ms",
        .ours = 1e3 * moving[w].lag_s};
    if (w == kOurs) {
      // A command is the reference's next value: a cycle ahead of the state it answers.
      const double demanded = resampling - kCycleSeconds;
      comparison.demand = fmt::format(
          "the resampler's {:.4g} less the cycle that a command is ahead", 1e3 * resampling);
      comparison.verdict = Judge(std::abs(moving[w].lag_s - demanded) < 1e-6);
    }
    findings.comparisons.push_back(std::move(comparison));
    findings.comparisons.push_back(
        {.quantity =
             fmt::format("error behind an admissible source, less that lag, {}", ways[w].name),
         .unit = "mrad",
         .ours = 1e3 * moving[w].error,
         .demand = w == kOurs ? "at most 1e-5" : "",
         .verdict = w == kOurs ? Judge(moving[w].error <= 1e-8) : Verdict::kReported});
  }
}

Figure ErrorsFigure(const std::vector<ConvergenceWay>& ways,
                    const std::array<std::vector<Convergence>, 2>& all) {
  constexpr std::size_t kEvery = 10;
  Figure figure{.id = "convergence", .columns = "source moves [-],way [-],t [s],error [rad]"};
  for (const ConvergenceWay& way : ways) figure.names.emplace_back(way.name);
  for (std::size_t moves = 0; moves < all.size(); ++moves) {
    for (std::size_t w = 0; w < ways.size(); ++w) {
      const std::vector<double>& errors = all.at(moves)[w].errors;
      for (std::size_t k = 0; k < errors.size() / 2; k += kEvery) {
        figure.rows.push_back({static_cast<double>(moves), static_cast<double>(w),
                               static_cast<double>(k) * kCycleSeconds, errors[k]});
      }
    }
  }
  return figure;
}

}  // namespace

std::vector<ConvergenceWay> ConvergenceWays(const scenario::RobotData& robot) {
  loop::TickConfig slow;
  slow.lambda = 1e-3;
  slow.limits = robot.limits;
  loop::TickConfig fast = slow;
  fast.lambda = 1e-2;
  loop::TickConfig limited = slow;
  limited.generator = loop::Generator::kNone;
  loop::TickConfig ours = slow;
  ours.generator = loop::Generator::kRejoining;
  ours.viability = reference::ViabilityFilter::kLostByDefault;
  return {{"saturated correction", ours},
          {"lambda = 1e-3", slow},
          {"lambda = 1e-2", fast},
          {"stream, client's limiter", WithLimiter(limited, robot)}};
}

Convergence MeasureConvergence(const loop::TickConfig& tick, const JointVector& rest, double offset,
                               bool moves) {
  const Source source{.middle = rest[0], .moves = moves};
  JointVector start = rest;
  start[0] -= offset;
  ChainBench bench(tick, start);
  Convergence convergence;
  std::vector<double> q_d;
  q_d.reserve(kCycles);
  for (int k = 0; k < kCycles; ++k) {
    const double t = k * kCycleSeconds;
    bench.Step(source.q(t), source.deposited_dq(t), true);
    q_d.push_back(bench.q_d());
    convergence.share = std::max(convergence.share, bench.LargestShare(tick.limits));
  }
  convergence.lag_s = LagOf(q_d, source);
  for (std::size_t k = 0; k < q_d.size(); ++k) {
    const double t = static_cast<double>(k) * kCycleSeconds - convergence.lag_s;
    convergence.errors.push_back(q_d[k] - source.q(t));
    convergence.overshoot = std::max(convergence.overshoot, convergence.errors.back() / offset);
    const bool at_the_end = k + 1000 >= q_d.size();
    if (at_the_end) {
      convergence.error = std::max(convergence.error, std::abs(convergence.errors.back()));
    }
  }
  convergence.time_s = TimeUntilClose(convergence.errors);
  return convergence;
}

void AddConvergence(const scenario::RobotData& robot, Findings& findings) {
  const std::vector<ConvergenceWay> ways = ConvergenceWays(robot);
  JointVector rest = MiddleOf(robot.limits);
  constexpr double kMiddle = 0.3;  // rad: no number of the middle of the range itself
  rest[0] = kMiddle;
  std::array<std::vector<Convergence>, 2> drawn;
  for (const bool moves : {false, true}) {
    for (const double offset : kOffsets) {
      std::vector<Convergence> all;
      all.reserve(ways.size());
      for (const ConvergenceWay& way : ways) {
        all.push_back(MeasureConvergence(way.tick, rest, offset, moves));
      }
      Compare(ways, all, offset, moves, findings);
      if (!moves) CompareWithFastest(all[kOurs], robot.limits, offset, findings);
      if (offset == kDrawnOffset) drawn.at(moves ? 1 : 0) = std::move(all);
    }
  }
  CompareLags(ways, drawn[1], findings);
  findings.figures.push_back(ErrorsFigure(ways, drawn));
}

}  // namespace twin::experiment

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "experiment/statistics.h"
#include "experiment/viability.h"
#include "twin/reference/resampler.h"
#include "twin/reference/viability_filter.h"

namespace twin::experiment {
namespace {

constexpr int kConvergenceCycles = 20'000;
constexpr int kHostileCycles = 12'000;
constexpr double kClose = 1e-4;                            ///< rad
constexpr std::array<double, 3> kOffsets{0.01, 0.1, 0.5};  ///< rad
constexpr double kDrawnOffset = 0.1;
constexpr std::size_t kOurChain = 0;

/// The source's joint 1.
struct SwingSource {
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
  /// Of a deposit: the mean since the previous one.
  [[nodiscard]] double deposited_dq(double t) const {
    return (q(t) - q(t - kCycleSeconds)) / kCycleSeconds;
  }
};

/// The lag of joint 1 behind the source over the last quarter, s.
double LagOf(const std::vector<double>& q_d, const SwingSource& source) {
  if (!source.moves) return 0;
  return LeastSquaresDelay(4, [&](double lag_s) {
    DelaySums sums;
    for (std::size_t k = q_d.size() * 3 / 4; k < q_d.size(); ++k) {
      const double t = static_cast<double>(k) * kCycleSeconds - lag_s;
      sums.product += (source.q(t) - q_d[k]) * source.dq(t);
      sums.square += source.dq(t) * source.dq(t);
    }
    return sums;
  });
}

/// Time of the last cycle that was not close, s; NaN when that is in the last quarter.
double TimeUntilClose(const std::vector<double>& errors) {
  std::size_t k = errors.size();
  while (k > 0 && std::abs(errors[k - 1]) <= kClose) --k;
  if (k > errors.size() * 3 / 4) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(k) * kCycleSeconds;
}

std::string CaseName(double offset, bool moves) {
  return fmt::format("{} rad behind a source that {}", offset, moves ? "moves" : "stands");
}

void CompareConvergence(const std::vector<Chain>& chains, const std::vector<Convergence>& all,
                        double offset, bool moves, Findings& findings) {
  for (std::size_t c = 0; c < chains.size(); ++c) {
    const bool is_ours = c == kOurChain;
    if (!is_ours && offset != kDrawnOffset) continue;  // one offset of the others is enough
    const std::string name = fmt::format("{}, {}: ", CaseName(offset, moves), chains[c].name);
    const Convergence& one = all[c];
    const bool is_sooner = one.time_s < all[1].time_s || std::isnan(all[1].time_s);
    findings.Add(name + "until within 0.1 mrad for good", "s", one.time_s)
        .Demand(is_ours ? "sooner than with lambda = 1e-3" : "", is_sooner);
    findings.Add(name + "overshoot", "%", 100 * one.overshoot)
        .Demand(is_ours ? "at most 0.1 % of the offset" : "", one.overshoot <= 1e-3);
    findings.Add(name + "largest share of a limit", "", one.share)
        .Demand(is_ours ? "at most 1" : "", one.share <= 1);
  }
}

/// Our time to a standing source over that of the fastest motion behind the same filter.
void CompareWithFastest(const Convergence& ours, const JointLimits& limits, double offset,
                        Findings& findings) {
  const double fastest = RestToRestTime(reference::BoundsOf(limits, 0),
                                        reference::ViabilityFilter::kLostByDefault, offset, kClose);
  findings.Add(fmt::format("{}, saturated correction: time over that of the fastest way",
                           CaseName(offset, false)),
               "", ours.time_s / fastest);
}

/// The lags behind an admissible source: ours is the resampler's alone.
void CompareLags(const std::vector<Chain>& chains, const std::vector<Convergence>& moving,
                 Findings& findings) {
  const double resampling = reference::Resampler(1 / kCycleSeconds).lag_s();
  // A command is the reference's next value: a cycle ahead of the state it answers.
  const double demanded = resampling - kCycleSeconds;
  for (std::size_t c = 0; c < chains.size(); ++c) {
    const bool is_ours = c == kOurChain;
    findings
        .Add(fmt::format("lag behind an admissible source, {}", chains[c].name), "ms",
             1e3 * moving[c].lag_s)
        .Demand(is_ours ? fmt::format("the resampler's {:.4g} less the cycle that a command is "
                                      "ahead",
                                      1e3 * resampling)
                        : "",
                std::abs(moving[c].lag_s - demanded) < 1e-6);
    findings
        .Add(fmt::format("error behind an admissible source, less that lag, {}", chains[c].name),
             "mrad", 1e3 * moving[c].error)
        .Demand(is_ours ? "at most 1e-5" : "", moving[c].error <= 1e-8);
  }
}

/// The source's position. Beyond the range of +-2.9 rad, at up to 2.7 rad/s.
double WishedAt(double t) {
  constexpr double kAmplitude = 3.2;  // rad
  constexpr double kOmega = 0.85;     // rad/s
  constexpr double kJumpAt = 9;       // s
  constexpr double kJump = -1;        // rad
  return kAmplitude * std::sin(kOmega * t) + (t < kJumpAt ? 0 : kJump);
}

/// In the last of every three seconds one of twenty commands arrives.
bool IsLost(int cycle) {
  constexpr int kOneOf = reference::ViabilityFilter::kLostByDefault + 1;
  return cycle % 3000 >= 2000 && cycle % kOneOf != 0;
}

}  // namespace

loop::TickConfig TickBehind(loop::Generator generator, const scenario::RobotData& robot,
                            double lambda) {
  loop::TickConfig tick;
  tick.generator = generator;
  tick.lambda = lambda;
  tick.limits = robot.limits;
  tick.cartesian = robot.cartesian;
  if (generator == loop::Generator::kRejoining) {
    tick.viability = reference::ViabilityFilter::kLostByDefault;
  }
  return tick;
}

std::vector<Chain> ComparedChains(const scenario::RobotData& robot) {
  using enum loop::Generator;
  return {{"saturated correction", TickBehind(kRejoining, robot)},
          {"lambda = 1e-3", TickBehind(kJoint, robot)},
          {"lambda = 1e-2", TickBehind(kJoint, robot, 1e-2)},
          {"stream, client's limiter", WithLimiter(TickBehind(kNone, robot), robot)}};
}

Convergence MeasureConvergence(const loop::TickConfig& tick, const JointVector& rest, double offset,
                               bool moves) {
  const SwingSource source{.middle = rest[0], .moves = moves};
  JointVector start = rest;
  start[0] -= offset;
  ChainBench bench(tick, start);
  Convergence convergence;
  std::vector<double> q_d;
  q_d.reserve(kConvergenceCycles);
  for (int k = 0; k < kConvergenceCycles; ++k) {
    const double t = k * kCycleSeconds;
    bench.Step(source.q(t), source.deposited_dq(t), true);
    q_d.push_back(bench.q_d());
    convergence.share = std::max(convergence.share, bench.LargestShare());
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
  constexpr std::size_t kEvery = 10;
  const std::vector<Chain> chains = ComparedChains(robot);
  JointVector rest = MiddleOf(robot.limits);
  rest[0] = 0.3;  // rad: off the middle of the range
  Figure figure{.id = "convergence",
                .columns = "source moves [-],way [-],t [s],error [rad]",
                .names = NamesOf(chains)};
  std::vector<Convergence> moving;
  for (const bool moves : {false, true}) {
    for (const double offset : kOffsets) {
      std::vector<Convergence> all;
      all.reserve(chains.size());
      for (const Chain& chain : chains) {
        all.push_back(MeasureConvergence(chain.tick, rest, offset, moves));
      }
      CompareConvergence(chains, all, offset, moves, findings);
      if (!moves) CompareWithFastest(all[kOurChain], robot.limits, offset, findings);
      if (offset != kDrawnOffset) continue;
      if (moves) moving = all;
      for (std::size_t c = 0; c < chains.size(); ++c) {
        for (std::size_t k = 0; k < all[c].errors.size() / 2; k += kEvery) {
          figure.rows.push_back(
              Row(moves, c, static_cast<double>(k) * kCycleSeconds, all[c].errors[k]));
        }
      }
    }
  }
  CompareLags(chains, moving, findings);
  findings.figures.push_back(std::move(figure));
}

std::vector<HostileCycle> RunHostileSource(const loop::TickConfig& tick) {
  ChainBench bench(tick, MiddleOf(tick.limits));
  std::vector<HostileCycle> cycles;
  cycles.reserve(kHostileCycles);
  for (int k = 0; k < kHostileCycles; ++k) {
    const double t = k * kCycleSeconds;
    const double wished = WishedAt(t);
    const double dq = (wished - WishedAt(t - kCycleSeconds)) / kCycleSeconds;
    const bool is_lost = IsLost(k);
    bench.Step(wished, dq, true, is_lost);
    cycles.push_back({.t = t,
                      .wished = wished,
                      .q_d = bench.q_d(),
                      .dq_d = bench.dq_d(),
                      .share = bench.LargestShare(),
                      .margin = bench.margin().value_or(0),
                      .kept_back = bench.kept_back(),
                      .is_lost = is_lost});
  }
  return cycles;
}

void AddHostileSource(const scenario::RobotData& robot, Findings& findings) {
  constexpr std::size_t kEvery = 4;
  constexpr double kMostShare = 1 + 1e-9;  // the tolerance of the robot's own checks
  const std::vector<Chain> chains = ComparedChains(robot);
  const auto beyond_range = [&](const HostileCycle& cycle) {
    return std::max(robot.limits.q_min[0] - cycle.q_d, cycle.q_d - robot.limits.q_max[0]);
  };
  for (std::size_t c = 0; c < chains.size(); ++c) {
    const std::vector<HostileCycle> cycles = RunHostileSource(chains[c].tick);
    const auto breaches = std::ranges::count_if(cycles, [&](const HostileCycle& cycle) {
      return cycle.share > kMostShare || beyond_range(cycle) > 0;
    });
    const std::string name = fmt::format(
        "a source that asks for too much, 19 of 20 lost at times, {}: ", chains[c].name);
    const bool is_ours = c == kOurChain;
    findings.Add(name + "cycles beyond a limit", "", breaches)
        .Demand(is_ours ? "none" : "", breaches == 0);
    findings.Add(name + "largest share of a limit", "",
                 std::ranges::max(ValuesOf(cycles, &HostileCycle::share)));
    findings.Add(name + "beyond the range by at most", "rad",
                 std::max(0.0, std::ranges::max(ValuesOf(cycles, beyond_range))));
    if (!is_ours) continue;
    Figure& figure = findings.figures.emplace_back(
        Figure{.id = "hostile",
               .columns = "t [s],wished [rad],q_d [rad],dq_d [rad/s],share [-],margin [-],kept "
                          "back [-],lost [-]",
               .values = {{"q_min", robot.limits.q_min[0]},
                          {"q_max", robot.limits.q_max[0]},
                          {"dq_max", robot.limits.dq_max[0]}}});
    for (std::size_t k = 0; k < cycles.size(); k += kEvery) {
      const HostileCycle& cycle = cycles[k];
      figure.rows.push_back(Row(cycle.t, cycle.wished, cycle.q_d, cycle.dq_d, cycle.share,
                                cycle.margin, cycle.kept_back, cycle.is_lost));
    }
  }
}

}  // namespace twin::experiment

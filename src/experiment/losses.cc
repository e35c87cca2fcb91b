#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/recording.h"
#include "experiment/runs.h"
#include "experiment/studies.h"

namespace twin::experiment {
namespace {

/// A command chain behind the plan.
struct LossChain {
  std::string_view name;
  loop::Generator generator;
  bool limiter;
  bool low_pass;
  bool filter;
};
constexpr std::array kLossChains{
    LossChain{"stream of positions", loop::Generator::kNone, false, false, false},
    LossChain{"the paper's law", loop::Generator::kJoint, false, false, false},
    LossChain{"the paper's law, limiter", loop::Generator::kJoint, true, false, false},
    LossChain{"the paper's law, limiter, low-pass", loop::Generator::kJoint, true, true, false},
    LossChain{"rejoining generator, viability filter", loop::Generator::kRejoining, false, false,
              true},
};
constexpr std::size_t kOurLossChain = 4;

constexpr std::array<int, 6> kBursts{1, 3, 5, 10, 15, 19};
constexpr std::array<double, 5> kShares{0.1, 1, 5, 20, 50};       ///< of all commands, %
constexpr std::array<double, 4> kBurstsPerSecond{0.5, 2, 5, 10};  ///< of the map
constexpr int kLongest = reference::ViabilityFilter::kLostByDefault;

/// One chain at one pace under bursts of losses, or with each command lost on its own.
struct LossCase {
  std::size_t pace = 0;
  std::size_t chain = 0;
  Bursts bursts{};           ///< of length 0: independent losses
  double share_percent = 0;  ///< of independent losses
};

/// The runs of a case.
struct LossOutcome {
  int runs = 0;
  int aborted = 0;
  double rms = 0;      ///< mean of the completed runs; rad, worst joint, without the delay
  double delay_s = 0;  ///< behind the plan, mean of the completed runs

  [[nodiscard]] double aborted_percent() const { return 100.0 * aborted / runs; }
  [[nodiscard]] double rms_mrad() const {
    return aborted == runs ? std::numeric_limits<double>::quiet_NaN() : 1e3 * rms;
  }
};

scenario::Scenario LossScenario(const Config& config, const LossCase& what) {
  const LossChain& chain = kLossChains.at(what.chain);
  scenario::Scenario scenario = LoadScenario(config, "asynchronous");
  RemoveTimingFaults(scenario);  // losses alone
  SetPace(config, kPaces.at(what.pace), scenario);
  scenario.tick.generator = chain.generator;
  scenario.tick.limiter = chain.limiter;
  if (chain.low_pass) scenario.tick.low_pass_hz = 100;  // the client library's default
  if (chain.filter) scenario.tick.viability = kLongest;
  return scenario;
}

LossOutcome MeasureLosses(const Config& config, const LossCase& what, int runs) {
  scenario::Scenario scenario = LossScenario(config, what);
  const reference::Trajectory plan = PlanOf(config, scenario);
  LossOutcome outcome{.runs = runs};
  for (int run = 0; run < runs; ++run) {
    scenario.seed = SeedOfRun(config, run);
    scenario.link.command.loss = what.bursts.length == 0
                                     ? scenario::Loss{scenario::IndependentLoss{what.share_percent}}
                                     : LossOf(config, what.bursts, ToSeconds(plan.duration()), run);
    Recording recording;
    const run::RunResult result = RunScenario(config, scenario, &recording);
    if (result.report.end == backend::MotionEnd::kAborted) {
      ++outcome.aborted;
      continue;
    }
    const double delay = DelayBehind(plan, recording.cycles(), &CycleSample::q_d);
    outcome.delay_s += delay;
    outcome.rms += std::ranges::max(RmsError(plan, recording.cycles(), &CycleSample::q_d, delay));
  }
  outcome.rms /= std::max(1, runs - outcome.aborted);
  outcome.delay_s /= std::max(1, runs - outcome.aborted);
  return outcome;
}

/// Several cases, measured on all processors.
struct LossStudy {
  LossStudy(const Config& config, std::vector<LossCase> all, int runs, double from, double to)
      : cases(std::move(all)),
        outcomes(MapInParallel(
            config, cases.size(), [&](int i) { return MeasureLosses(config, cases[i], runs); },
            from, to)) {}

  std::vector<LossCase> cases;
  std::vector<LossOutcome> outcomes;  ///< of each case
};

/// The given losses behind every chain at every pace, in that order.
class LossTable {
 public:
  LossTable(const Config& config, const std::vector<LossCase>& losses, int runs, double from,
            double to)
      : losses_(losses.size()), study_(config, CasesOf(losses), runs, from, to) {}

  [[nodiscard]] const LossOutcome* Of(std::size_t pace, std::size_t chain) const {
    return &study_.outcomes[(pace * kLossChains.size() + chain) * losses_];
  }

 private:
  static std::vector<LossCase> CasesOf(const std::vector<LossCase>& losses) {
    std::vector<LossCase> cases;
    for (std::size_t pace = 0; pace < kPaces.size(); ++pace) {
      for (std::size_t chain = 0; chain < kLossChains.size(); ++chain) {
        for (const LossCase& loss : losses) {
          cases.push_back({pace, chain, loss.bursts, loss.share_percent});
        }
      }
    }
    return cases;
  }

  std::size_t losses_;
  LossStudy study_;
};

std::vector<std::string> LossChainNames() {
  std::vector<std::string> names;
  for (const LossChain& chain : kLossChains) names.emplace_back(chain.name);
  return names;
}

/// Share of aborted runs over length and rate of the bursts, at the hard pace.
Figure BurstMapFigure(const Config& config, int runs, double from, double to) {
  std::vector<LossCase> cases;
  for (std::size_t chain = 0; chain < kLossChains.size(); ++chain) {
    for (const double per_second : kBurstsPerSecond) {
      for (const int length : kBursts) {
        cases.push_back({kPaces.size() - 1, chain, {length, per_second}});
      }
    }
  }
  const LossStudy study(config, std::move(cases), runs, from, to);
  Figure figure{.id = "map",
                .columns =
                    "way [-],bursts a second [-],commands lost in a row [-],aborted [%],"
                    "RMS error [mrad]",
                .names = LossChainNames()};
  for (std::size_t i = 0; i < study.cases.size(); ++i) {
    const auto& [pace, chain, bursts, share] = study.cases[i];
    figure.rows.push_back({static_cast<double>(chain), bursts.per_second,
                           static_cast<double>(bursts.length), study.outcomes[i].aborted_percent(),
                           study.outcomes[i].rms_mrad()});
  }
  return figure;
}

/// Our chain under bursts of every length that the robot bridges.
void CompareEveryLength(const Config& config, int runs, double from, double to,
                        Findings& findings) {
  std::vector<LossCase> cases;
  for (std::size_t pace = 0; pace < kPaces.size(); ++pace) {
    for (int length = 1; length <= kLongest; ++length) {
      cases.push_back({pace, kOurLossChain, {.length = length}});
    }
  }
  const LossStudy study(config, std::move(cases), runs, from, to);
  int aborted = 0;
  double largest = 0;
  for (const LossOutcome& outcome : study.outcomes) {
    aborted += outcome.aborted;
    largest = std::fmax(largest, outcome.rms_mrad());
  }
  findings
      .Add(fmt::format("all tempos, every length of bursts from 1 to {}, ours: aborted of {} runs",
                       kLongest, study.cases.size() * runs),
           "", aborted)
      .Demand("none", aborted == 0);
  findings.Add("the same: largest RMS error without its delay", "mrad", largest);
}

/// Aborted runs and errors of each pace and chain.
Figure OutcomesFigure(std::string id, std::string title, const std::string& x_label,
                      const std::vector<double>& x, const LossTable& table) {
  Figure figure{.id = std::move(id),
                .plot = "outcomes",
                .columns = x_label + ",tempo [-],way [-],aborted [%],RMS error [mrad]",
                .names = LossChainNames()};
  figure.names.push_back(x_label);
  figure.names.push_back(std::move(title));
  for (std::size_t pace = 0; pace < kPaces.size(); ++pace) {
    double& completed = figure.values[fmt::format("completed_{}", pace)];
    for (std::size_t chain = 0; chain < kLossChains.size(); ++chain) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        const LossOutcome& outcome = table.Of(pace, chain)[i];
        completed += outcome.aborted < outcome.runs ? 1 : 0;
        figure.rows.push_back({x[i], static_cast<double>(pace), static_cast<double>(chain),
                               outcome.aborted_percent(), outcome.rms_mrad()});
      }
    }
  }
  return figure;
}

void CompareBursts(const LossTable& table, Findings& findings) {
  for (std::size_t p = 0; p < kPaces.size(); ++p) {
    const std::string_view pace = kPaces[p].name;
    for (std::size_t c = 0; c < kLossChains.size(); ++c) {
      int aborted = 0;
      int runs = 0;
      for (std::size_t i = 0; i < kBursts.size(); ++i) {
        aborted += table.Of(p, c)[i].aborted;
        runs += table.Of(p, c)[i].runs;
      }
      findings
          .Add(fmt::format("{}, bursts of 1 to 19, {}: aborted, {} runs", pace, kLossChains[c].name,
                           runs),
               "%", 100.0 * aborted / runs)
          .Demand(c == kOurLossChain ? "none" : "", aborted == 0);
    }
    for (std::size_t c = 0; c < kLossChains.size(); ++c) {
      findings.Add(fmt::format("{}, bursts of 19, {}: RMS error without its delay", pace,
                               kLossChains[c].name),
                   "mrad", table.Of(p, c)[kBursts.size() - 1].rms_mrad());
    }
    for (std::size_t c = 0; c < kLossChains.size(); ++c) {
      findings.Add(fmt::format("{}, one command lost at a time, {}: delay behind the plan", pace,
                               kLossChains[c].name),
                   "ms", 1e3 * table.Of(p, c)[0].delay_s);
    }
  }
}

/// The longest bursts that abort no run: where our chain makes no difference.
void CompareSurvived(const LossTable& table, Findings& findings) {
  for (std::size_t p = 0; p < kPaces.size(); ++p) {
    for (std::size_t c = 0; c < kLossChains.size(); ++c) {
      int survived = 0;
      for (std::size_t i = 0; i < kBursts.size() && table.Of(p, c)[i].aborted == 0; ++i) {
        survived = kBursts[i];
      }
      findings.Add(fmt::format("{}, {}: bursts up to this length abort nothing", kPaces[p].name,
                               kLossChains[c].name),
                   "commands", survived);
    }
  }
}

}  // namespace

Findings RunLosses(const Config& config) {
  const int runs = std::min(config.seeds, 3);
  std::vector<LossCase> bursts;
  for (const int length : kBursts) bursts.push_back({.bursts = {.length = length}});
  std::vector<LossCase> shares;
  for (const double share : kShares) shares.push_back({.share_percent = share});
  const LossTable by_burst(config, bursts, runs, 0, 0.3);
  const LossTable by_share(config, shares, runs, 0.3, 0.55);
  Findings findings{.values = {{"per_second", fmt::format("{}", Bursts().per_second)},
                               {"runs", fmt::format("{}", runs)}}};
  CompareBursts(by_burst, findings);
  CompareEveryLength(config, runs, 0.55, 0.8, findings);
  CompareSurvived(by_burst, findings);
  findings.figures = {OutcomesFigure("bursts", "Bursts of losses", "commands lost in a row",
                                     {kBursts.begin(), kBursts.end()}, by_burst),
                      OutcomesFigure("shares", "Independent losses", "lost commands [%]",
                                     {kShares.begin(), kShares.end()}, by_share),
                      BurstMapFigure(config, runs, 0.8, 1)};
  return findings;
}

}  // namespace twin::experiment

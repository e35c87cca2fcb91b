#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "experiment/studies.h"

namespace twin::experiment {
namespace {

/// A command chain behind the plan; the rejoining generator has the viability filter behind it.
struct LossChain {
  std::string_view name;
  loop::Generator generator;
  bool limiter = false;
  bool low_pass = false;
};
constexpr std::array kLossChains{
    LossChain{"stream of positions", loop::Generator::kNone},
    LossChain{"the paper's law", loop::Generator::kJoint},
    LossChain{"the paper's law, limiter", loop::Generator::kJoint, true},
    LossChain{"the paper's law, limiter, low-pass", loop::Generator::kJoint, true, true},
    LossChain{"rejoining generator, viability filter", loop::Generator::kRejoining},
};
constexpr std::size_t kOurLossChain = 4;

constexpr std::array<int, 6> kBursts{1, 3, 5, 10, 15, 19};
constexpr std::array<double, 5> kShares{0.1, 1, 5, 20, 50};       ///< of all commands, %
constexpr std::array<double, 4> kBurstsPerSecond{0.5, 2, 5, 10};  ///< of the map
constexpr int kLongest = reference::ViabilityFilter::kLostByDefault;

/// Bursts of losses; of length 0: each command is lost on its own.
struct Losses {
  Bursts bursts{};
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

scenario::Scenario LossScenario(const Config& config, std::size_t pace, const LossChain& chain) {
  scenario::Scenario scenario = LoadScenario(config, "asynchronous");
  RemoveTimingFaults(scenario);  // losses alone
  SetPace(config, kPaces.at(pace), scenario);
  scenario.tick.generator = chain.generator;
  scenario.tick.limiter = chain.limiter;
  if (chain.low_pass) scenario.tick.low_pass_hz = 100;  // the client library's default
  if (chain.generator == loop::Generator::kRejoining) scenario.tick.viability = kLongest;
  return scenario;
}

LossOutcome MeasureLosses(const Config& config, std::size_t pace, std::size_t chain,
                          const Losses& losses, int runs) {
  scenario::Scenario scenario = LossScenario(config, pace, kLossChains.at(chain));
  const reference::Trajectory plan = PlanOf(config, scenario);
  LossOutcome outcome{.runs = runs};
  for (int run = 0; run < runs; ++run) {
    scenario.seed = SeedOfRun(config, run);
    scenario.link.command.loss =
        losses.bursts.length == 0 ? scenario::Loss{scenario::IndependentLoss{losses.share_percent}}
                                  : LossOf(config, losses.bursts, plan.duration(), run);
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

/// Losses behind every chain at every pace: a row for each chain, pace by pace.
using LossTable = Grid<LossOutcome>;

LossTable MeasureTable(const Config& config, const std::vector<Losses>& losses, int runs) {
  return MapGrid(config, kPaces.size() * kLossChains.size(), losses.size(),
                 [&](std::size_t row, std::size_t i) {
                   return MeasureLosses(config, row / kLossChains.size(), row % kLossChains.size(),
                                        losses[i], runs);
                 });
}

/// Share of aborted runs over length and rate of the bursts, at the hard pace.
Figure BurstMapFigure(const Config& config, int runs) {
  std::vector<Bursts> bursts;
  for (const double per_second : kBurstsPerSecond) {
    for (const int length : kBursts) bursts.push_back({length, per_second});
  }
  const LossTable table =
      MapGrid(config, kLossChains.size(), bursts.size(), [&](std::size_t chain, std::size_t i) {
        return MeasureLosses(config, kPaces.size() - 1, chain, {bursts[i]}, runs);
      });
  Figure figure{.id = "map",
                .columns =
                    "way [-],bursts a second [-],commands lost in a row [-],aborted [%],"
                    "RMS error [mrad]",
                .names = NamesOf(kLossChains)};
  for (std::size_t chain = 0; chain < kLossChains.size(); ++chain) {
    for (std::size_t i = 0; i < bursts.size(); ++i) {
      const LossOutcome& outcome = table[chain][i];
      figure.rows.push_back(Row(chain, bursts[i].per_second, bursts[i].length,
                                outcome.aborted_percent(), outcome.rms_mrad()));
    }
  }
  return figure;
}

/// Our chain under bursts of every length that the robot bridges.
void CompareEveryLength(const Config& config, int runs, Findings& findings) {
  const LossTable table =
      MapGrid(config, kPaces.size(), kLongest, [&](std::size_t pace, std::size_t i) {
        return MeasureLosses(config, pace, kOurLossChain, {{.length = static_cast<int>(i) + 1}},
                             runs);
      });
  int aborted = 0;
  double largest = 0;
  for (const LossOutcome& outcome : table.all) {
    aborted += outcome.aborted;
    largest = std::fmax(largest, outcome.rms_mrad());
  }
  findings
      .Add(fmt::format("all tempos, every length of bursts from 1 to {}, ours: aborted of {} runs",
                       kLongest, table.all.size() * runs),
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
                .names = NamesOf(kLossChains)};
  figure.names.push_back(x_label);
  figure.names.push_back(std::move(title));
  for (std::size_t pace = 0; pace < kPaces.size(); ++pace) {
    double& completed = figure.values[fmt::format("completed_{}", pace)];
    for (std::size_t chain = 0; chain < kLossChains.size(); ++chain) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        const LossOutcome& outcome = table[pace * kLossChains.size() + chain][i];
        completed += outcome.aborted < outcome.runs ? 1 : 0;
        figure.rows.push_back(
            Row(x[i], pace, chain, outcome.aborted_percent(), outcome.rms_mrad()));
      }
    }
  }
  return figure;
}

/// Adds a quantity of every chain at a pace. @param of  the chain's outcomes, burst by burst.
void AddOfChains(const LossTable& table, std::size_t pace, std::string_view text, const char* unit,
                 Findings& findings,
                 const std::function<double(std::span<const LossOutcome>)>& of) {
  for (std::size_t c = 0; c < kLossChains.size(); ++c) {
    findings.Add(fmt::format(fmt::runtime(text), kPaces[pace].name, kLossChains[c].name), unit,
                 of(table[pace * kLossChains.size() + c]));
  }
}

void CompareBursts(const LossTable& table, int runs, Findings& findings) {
  using Outcomes = std::span<const LossOutcome>;
  for (std::size_t pace = 0; pace < kPaces.size(); ++pace) {
    const std::string aborted =
        fmt::format("{{}}, bursts of 1 to 19, {{}}: aborted, {} runs", kBursts.size() * runs);
    AddOfChains(table, pace, aborted, "%", findings, [&](Outcomes outcomes) {
      int all = 0;
      for (const LossOutcome& outcome : outcomes) all += outcome.aborted;
      return 100.0 * all / static_cast<double>(kBursts.size() * runs);
    });
    Comparison& ours = findings.comparisons.back();
    ours.Demand("none", ours.ours == 0);
    AddOfChains(table, pace, "{}, bursts of 19, {}: RMS error without its delay", "mrad", findings,
                [](Outcomes outcomes) { return outcomes.back().rms_mrad(); });
    AddOfChains(table, pace, "{}, one command lost at a time, {}: delay behind the plan", "ms",
                findings, [](Outcomes outcomes) { return 1e3 * outcomes.front().delay_s; });
  }
}

/// The longest bursts that abort no run: where our chain makes no difference.
void CompareSurvived(const LossTable& table, Findings& findings) {
  for (std::size_t pace = 0; pace < kPaces.size(); ++pace) {
    AddOfChains(table, pace, "{}, {}: bursts up to this length abort nothing", "commands", findings,
                [](std::span<const LossOutcome> outcomes) {
                  const auto aborting = std::ranges::find_if(outcomes, &LossOutcome::aborted);
                  return aborting == outcomes.begin() ? 0
                                                      : kBursts[aborting - outcomes.begin() - 1];
                });
  }
}

}  // namespace

Findings RunLosses(const Config& config) {
  const int runs = std::min(config.seeds, 3);
  std::vector<Losses> bursts;
  bursts.reserve(std::size(kBursts));
  for (const int length : kBursts) bursts.push_back({.bursts = {.length = length}});
  std::vector<Losses> shares;
  shares.reserve(std::size(kShares));
  for (const double share : kShares) shares.push_back({.share_percent = share});
  const LossTable by_burst = MeasureTable(PartOf(config, 0, 0.3), bursts, runs);
  const LossTable by_share = MeasureTable(PartOf(config, 0.3, 0.55), shares, runs);
  Findings findings{.values = {{"per_second", fmt::format("{}", Bursts().per_second)},
                               {"runs", fmt::format("{}", runs)}}};
  CompareBursts(by_burst, runs, findings);
  CompareEveryLength(PartOf(config, 0.55, 0.8), runs, findings);
  CompareSurvived(by_burst, findings);
  findings.figures = {OutcomesFigure("bursts", "Bursts of losses", "commands lost in a row",
                                     {kBursts.begin(), kBursts.end()}, by_burst),
                      OutcomesFigure("shares", "Independent losses", "lost commands [%]",
                                     {kShares.begin(), kShares.end()}, by_share),
                      BurstMapFigure(PartOf(config, 0.8, 1), runs)};
  return findings;
}

}  // namespace twin::experiment

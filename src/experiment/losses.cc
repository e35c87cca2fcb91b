#include "experiment/losses.h"

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
#include "experiment/tempos.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {
namespace {

using scenario::Scenario;

/// How commands are made of the plan.
struct Way {
  std::string_view name;
  loop::Generator generator;
  bool limiter;
  bool low_pass;
  bool filter;
};
constexpr std::array kWays{
    Way{"stream of positions", loop::Generator::kNone, false, false, false},
    Way{"the paper's law", loop::Generator::kJoint, false, false, false},
    Way{"the paper's law, limiter", loop::Generator::kJoint, true, false, false},
    Way{"the paper's law, limiter, low-pass", loop::Generator::kJoint, true, true, false},
    Way{"rejoining generator, viability filter", loop::Generator::kRejoining, false, false, true},
};
constexpr std::size_t kOurs = 4;

constexpr std::array<int, 6> kBursts{1, 3, 5, 10, 15, 19};
constexpr std::array<double, 5> kShares{0.1, 1, 5, 20, 50};       ///< of all commands, %
constexpr std::array<double, 4> kBurstsPerSecond{0.5, 2, 5, 10};  ///< of the map
constexpr int kLongest = reference::ViabilityFilter::kLostByDefault;

/// What is lost: bursts of a length, or each command for itself.
struct Loss {
  Bursts bursts{};           ///< of length 0: each for itself
  double share_percent = 0;  ///< of those
};

/// What came of the runs of one way.
struct Outcome {
  int runs = 0;
  int aborted = 0;
  double rms = 0;  ///< of the runs that ended well, the mean; rad, worst joint, without its delay
  double delay_s = 0;  ///< behind the plan, the mean of the same

  [[nodiscard]] double aborted_percent() const { return 100.0 * aborted / runs; }
  [[nodiscard]] double rms_mrad() const {
    return aborted == runs ? std::numeric_limits<double>::quiet_NaN() : 1e3 * rms;
  }
};

Scenario MakeScenario(const Setting& setting, const Tempo& tempo, const Way& way) {
  Scenario scenario = LoadScenario(setting, "asynchronous");
  TakeOutTimingFaults(scenario);  // losses alone are to be judged
  SetTempo(setting, tempo, scenario);
  scenario.tick.generator = way.generator;
  scenario.tick.limiter = way.limiter;
  if (way.low_pass) scenario.tick.low_pass_hz = 100;  // the client library's default
  if (way.filter) scenario.tick.viability = reference::ViabilityFilter::kLostByDefault;
  return scenario;
}

Outcome Measure(const Setting& setting, const Tempo& tempo, const Way& way, const Loss& loss,
                int runs) {
  Scenario scenario = MakeScenario(setting, tempo, way);
  const reference::Trajectory plan = run::MakeTrajectory(
      scenario,
      scenario::LoadRobotData(setting.files.models, scenario.robot.model, scenario.robot.hand));
  Outcome outcome{.runs = runs};
  for (int run = 0; run < runs; ++run) {
    scenario.seed = SeedOfRun(setting, run);
    scenario.link.command.loss =
        loss.bursts.length == 0 ? scenario::Loss{scenario::IndependentLoss{loss.share_percent}}
                                : LossOf(setting, loss.bursts, ToSeconds(plan.duration()), run);
    Recording recording;
    const run::RunResult result = RunScenario(setting, scenario, &recording);
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

/// One way at one tempo under one kind of losses.
struct Job {
  std::size_t tempo = 0;
  std::size_t way = 0;
  Loss loss;
};

std::vector<Outcome> MeasureAll(const Setting& setting, const std::vector<Job>& jobs, int runs,
                                double from, double to) {
  std::vector<Outcome> outcomes(jobs.size());
  InParallel(
      setting, static_cast<int>(jobs.size()),
      [&](int i) {
        const Job& job = jobs[static_cast<std::size_t>(i)];
        outcomes[static_cast<std::size_t>(i)] =
            Measure(setting, kTempos.at(job.tempo), kWays.at(job.way), job.loss, runs);
      },
      from, to);
  return outcomes;
}

/// By tempo, way and loss.
using Outcomes = std::vector<std::vector<std::vector<Outcome>>>;

Outcomes MeasureTable(const Setting& setting, const std::vector<Loss>& losses, int runs,
                      double from, double to) {
  std::vector<Job> jobs;
  for (std::size_t tempo = 0; tempo < kTempos.size(); ++tempo) {
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      for (const Loss& loss : losses) jobs.push_back({tempo, way, loss});
    }
  }
  const std::vector<Outcome> all = MeasureAll(setting, jobs, runs, from, to);
  Outcomes outcomes(kTempos.size(), std::vector<std::vector<Outcome>>(kWays.size()));
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    outcomes[jobs[i].tempo][jobs[i].way].push_back(all[i]);
  }
  return outcomes;
}

std::vector<std::string> WayNames() {
  std::vector<std::string> names;
  for (const Way& way : kWays) names.emplace_back(way.name);
  return names;
}

/// Share of aborted runs against how long bursts are and how often they come, at the hard tempo.
Figure MapAborts(const Setting& setting, int runs, double from, double to) {
  std::vector<Job> jobs;
  for (std::size_t way = 0; way < kWays.size(); ++way) {
    for (const double per_second : kBurstsPerSecond) {
      for (const int length : kBursts) {
        jobs.push_back({kTempos.size() - 1, way, {.bursts = {length, per_second}}});
      }
    }
  }
  const std::vector<Outcome> outcomes = MeasureAll(setting, jobs, runs, from, to);
  Figure figure{.id = "map",
                .columns =
                    "way [-],bursts a second [-],commands lost in a row [-],aborted [%],"
                    "RMS error [mrad]",
                .names = WayNames()};
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const Bursts& bursts = jobs[i].loss.bursts;
    figure.rows.push_back({static_cast<double>(jobs[i].way), bursts.per_second,
                           static_cast<double>(bursts.length), outcomes[i].aborted_percent(),
                           outcomes[i].rms_mrad()});
  }
  return figure;
}

/// Ours under bursts of every length that the robot bridges.
void CompareEveryLength(const Setting& setting, int runs, double from, double to,
                        Findings& findings) {
  std::vector<Job> jobs;
  for (std::size_t tempo = 0; tempo < kTempos.size(); ++tempo) {
    for (int length = 1; length <= kLongest; ++length) {
      jobs.push_back({tempo, kOurs, {.bursts = {.length = length}}});
    }
  }
  const std::vector<Outcome> outcomes = MeasureAll(setting, jobs, runs, from, to);
  int aborted = 0;
  double largest = 0;
  for (const Outcome& outcome : outcomes) {
    aborted += outcome.aborted;
    largest = std::fmax(largest, outcome.rms_mrad());
  }
  findings.comparisons.push_back(
      {.quantity = fmt::format("all tempos, every length of bursts from 1 to {}, ours: aborted of "
                               "{} runs",
                               kLongest, static_cast<int>(jobs.size()) * runs),
       .ours = static_cast<double>(aborted),
       .demand = "none",
       .verdict = Judge(aborted == 0)});
  findings.comparisons.push_back({.quantity = "the same: largest RMS error without its delay",
                                  .unit = "mrad",
                                  .ours = largest});
}

/// Aborted runs and errors of each tempo and way.
Figure OutcomesFigure(std::string id, std::string title, const std::string& x_label,
                      const std::vector<double>& x, const Outcomes& outcomes) {
  Figure figure{.id = std::move(id),
                .plot = "outcomes",
                .columns = x_label + ",tempo [-],way [-],aborted [%],RMS error [mrad]",
                .names = WayNames()};
  figure.names.push_back(x_label);
  figure.names.push_back(std::move(title));
  for (std::size_t p = 0; p < kTempos.size(); ++p) {
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      for (std::size_t i = 0; i < x.size(); ++i) {
        const Outcome& outcome = outcomes[p][w][i];
        figure.rows.push_back({x[i], static_cast<double>(p), static_cast<double>(w),
                               outcome.aborted_percent(), outcome.rms_mrad()});
      }
    }
  }
  return figure;
}

void Compare(const Outcomes& bursts, Findings& findings) {
  for (std::size_t p = 0; p < kTempos.size(); ++p) {
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      int aborted = 0;
      int runs = 0;
      for (const Outcome& outcome : bursts[p][w]) {
        aborted += outcome.aborted;
        runs += outcome.runs;
      }
      Comparison comparison{.quantity = fmt::format("{}, bursts of 1 to 19, {}: aborted, {} runs",
                                                    kTempos[p].name, kWays[w].name, runs),
                            .unit = "%",
                            .ours = 100.0 * aborted / runs};
      if (w == kOurs) {
        comparison.demand = "none";
        comparison.verdict = Judge(aborted == 0);
      }
      findings.comparisons.push_back(comparison);
    }
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      const Outcome& longest = bursts[p][w].back();
      findings.comparisons.push_back(
          {.quantity = fmt::format("{}, bursts of 19, {}: RMS error without its delay",
                                   kTempos[p].name, kWays[w].name),
           .unit = "mrad",
           .ours = longest.rms_mrad()});
    }
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      findings.comparisons.push_back(
          {.quantity = fmt::format("{}, one command lost at a time, {}: delay behind the plan",
                                   kTempos[p].name, kWays[w].name),
           .unit = "ms",
           .ours = 1e3 * bursts[p][w].front().delay_s});
    }
  }
}

/// Where ours does not matter: up to which of the lengths no run was aborted.
void CompareSurvived(const Outcomes& bursts, Findings& findings) {
  for (std::size_t p = 0; p < kTempos.size(); ++p) {
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      int survived = 0;
      for (std::size_t i = 0; i < kBursts.size() && bursts[p][w][i].aborted == 0; ++i) {
        survived = kBursts.at(i);
      }
      findings.comparisons.push_back(
          {.quantity = fmt::format("{}, {}: bursts up to this length abort nothing",
                                   kTempos[p].name, kWays[w].name),
           .unit = "commands",
           .ours = static_cast<double>(survived)});
    }
  }
}

}  // namespace

Findings RunLosses(const Setting& setting) {
  const int runs = std::min(setting.seeds, 3);
  std::vector<Loss> bursts;
  bursts.reserve(kBursts.size());
  for (const int length : kBursts) bursts.push_back({.bursts = {.length = length}});
  std::vector<Loss> shares;
  shares.reserve(kShares.size());
  for (const double share : kShares) shares.push_back({.share_percent = share});
  const Outcomes by_burst = MeasureTable(setting, bursts, runs, 0, 0.3);
  const Outcomes by_share = MeasureTable(setting, shares, runs, 0.3, 0.55);
  Findings findings{.values = {{"per_second", fmt::format("{}", Bursts().per_second)},
                               {"runs", fmt::format("{}", runs)}}};
  Compare(by_burst, findings);
  CompareEveryLength(setting, runs, 0.55, 0.8, findings);
  CompareSurvived(by_burst, findings);
  findings.figures = {OutcomesFigure("bursts", "Bursts of losses", "commands lost in a row",
                                     {kBursts.begin(), kBursts.end()}, by_burst),
                      OutcomesFigure("shares", "Independent losses", "lost commands [%]",
                                     {kShares.begin(), kShares.end()}, by_share),
                      MapAborts(setting, runs, 0.8, 1)};
  return findings;
}

}  // namespace twin::experiment

#include "experiment/losses.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "experiment/recording.h"
#include "experiment/runs.h"
#include "twin/report/chart.h"
#include "twin/scenario/robot_data.h"

namespace twin::experiment {
namespace {

using scenario::Scenario;

/// How commands are made of the plan.
struct Way {
  std::string_view name;
  loop::Generator generator;
  bool limiter;
  bool filter;
};
constexpr std::array kWays{
    Way{"stream of positions", loop::Generator::kNone, false, false},
    Way{"the paper's generator", loop::Generator::kJoint, false, false},
    Way{"stream, client's limiter", loop::Generator::kNone, true, false},
    Way{"rejoining generator, viability filter", loop::Generator::kRejoining, false, true},
};
constexpr std::size_t kOurs = 3;

/// What is moved along: the largest acceleration as a share of its limit.
struct Pace {
  std::string_view name;
  double stretch;  ///< of the brisk trajectory's time; 0: it is the canonical one
};
constexpr std::array kPaces{Pace{"canonical", 0}, Pace{"brisk", 1}, Pace{"hard", 0.84}};

constexpr std::array<int, 6> kBursts{1, 3, 5, 10, 15, 19};
constexpr std::array<double, 5> kShares{0.1, 1, 5, 20, 50};  ///< of all commands, %

/// Bursts begin so often in the mean, per second.
constexpr double kBurstsPerSecond = 2;

/// What is lost: bursts of a length, or each command for itself.
struct Loss {
  int burst = 0;             ///< 0: each for itself
  double share_percent = 0;  ///< of those
};

/// What came of the runs of one way.
struct Outcome {
  int runs = 0;
  int aborted = 0;
  double rms = 0;  ///< of the runs that ended well, the mean; rad, worst joint, without its delay

  [[nodiscard]] double aborted_percent() const { return 100.0 * aborted / runs; }
  [[nodiscard]] double rms_mrad() const {
    return aborted == runs ? std::numeric_limits<double>::quiet_NaN() : 1e3 * rms;
  }
};

Scenario MakeScenario(const Setting& setting, const Pace& pace, const Way& way) {
  Scenario scenario = LoadScenario(setting, "asynchronous");
  TakeOutTimingFaults(scenario);  // losses alone are to be judged
  if (pace.stretch > 0) {
    scenario.motion = scenario::Load(setting.files.models / "scenarios" / "brisk.yaml").motion;
    scenario.motion.interface = control::CommandInterface::kJointPosition;
    scenario.motion.timing.duration.reset();
    for (reference::Waypoint& waypoint : scenario.motion.waypoints) {
      if (waypoint.at) waypoint.at = FromSeconds(ToSeconds(*waypoint.at) * pace.stretch);
    }
  }
  scenario.tick.generator = way.generator;
  scenario.tick.limiter = way.limiter;
  if (way.filter) scenario.tick.viability = reference::ViabilityFilter::kLostByDefault;
  return scenario;
}

/// Bursts at random instants, the same for every way.
scenario::Loss LossOf(const Setting& setting, const Loss& loss, double seconds, int run) {
  if (loss.burst == 0) return {scenario::IndependentLoss{loss.share_percent}};
  scenario::ScriptedLoss script;
  std::uint32_t draw = 0;
  std::int64_t at = 20;  // ms: the motion has begun
  for (;;) {
    const double wait = -std::log1p(-ChoiceOfRun(setting, run, ++draw)) / kBurstsPerSecond;
    at += std::llround(1e3 * wait) + 1;
    if (static_cast<double>(at + loss.burst) > 1e3 * seconds) break;
    script.bursts.push_back(
        {std::chrono::milliseconds(at), static_cast<std::uint64_t>(loss.burst)});
    at += loss.burst;
  }
  return {script};
}

Outcome Measure(const Setting& setting, const Pace& pace, const Way& way, const Loss& loss,
                int runs) {
  Scenario scenario = MakeScenario(setting, pace, way);
  const reference::Trajectory plan = scenario::MakeTrajectory(
      scenario,
      scenario::LoadRobotData(setting.files.models, scenario.robot.model, scenario.robot.hand));
  Outcome outcome{.runs = runs};
  for (int run = 0; run < runs; ++run) {
    scenario.seed = SeedOfRun(setting, run);
    scenario.link.command.loss = LossOf(setting, loss, ToSeconds(plan.duration()), run);
    Recording recording;
    const scenario::RunResult result = RunScenario(setting, scenario, &recording);
    if (result.report.end == backend::MotionEnd::kAborted) {
      ++outcome.aborted;
      continue;
    }
    const double delay = DelayBehind(plan, recording.cycles(), &CycleSample::q_d);
    outcome.rms += std::ranges::max(RmsError(plan, recording.cycles(), &CycleSample::q_d, delay));
  }
  outcome.rms /= std::max(1, runs - outcome.aborted);
  return outcome;
}

/// By pace, way and loss.
using Outcomes = std::vector<std::vector<std::vector<Outcome>>>;

Outcomes MeasureAll(const Setting& setting, const std::vector<Loss>& losses, int runs, double from,
                    double to) {
  Outcomes outcomes(kPaces.size(), std::vector<std::vector<Outcome>>(
                                       kWays.size(), std::vector<Outcome>(losses.size())));
  const auto count = static_cast<int>(kPaces.size() * kWays.size() * losses.size());
  InParallel(
      setting, count,
      [&](int job) {
        const auto i = static_cast<std::size_t>(job);
        const std::size_t loss = i % losses.size();
        const std::size_t way = i / losses.size() % kWays.size();
        const std::size_t pace = i / losses.size() / kWays.size();
        outcomes[pace][way][loss] = Measure(setting, kPaces[pace], kWays[way], losses[loss], runs);
      },
      from, to);
  return outcomes;
}

/// Of each pace a panel of aborted shares and one of errors.
Figure Draw(std::string id, std::string title, std::string what, const std::string& x_label,
            const std::vector<double>& x, const Outcomes& outcomes) {
  report::Chart chart{.title = title, .columns = 2, .width = 1000, .panel_height = 300};
  Figure figure{.id = std::move(id), .title = std::move(title), .what = std::move(what)};
  figure.columns = x_label + ",pace [-],way [-],aborted [%],RMS error [mrad]";
  for (std::size_t p = 0; p < kPaces.size(); ++p) {
    report::ChartPanel aborted{.title = fmt::format("{}: aborted", kPaces[p].name),
                               .x_label = x_label,
                               .y_label = "[%]",
                               .log_x = true,
                               .y_range = {{-5, 105}}};
    report::ChartPanel error{.title = fmt::format("{}: error of the completed", kPaces[p].name),
                             .x_label = x_label,
                             .y_label = "[mrad]",
                             .log_x = true,
                             .log_y = true};
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      report::ChartCurve curve{
          .name = std::string(kWays[w].name), .colour = report::colour::kSeries[w], .x = x};
      report::ChartCurve rms = curve;
      rms.name.clear();
      for (std::size_t i = 0; i < x.size(); ++i) {
        const Outcome& outcome = outcomes[p][w][i];
        curve.y.push_back(outcome.aborted_percent());
        rms.y.push_back(outcome.rms_mrad());
        figure.rows.push_back(
            {x[i], static_cast<double>(p), static_cast<double>(w), curve.y.back(), rms.y.back()});
      }
      aborted.curves.push_back(std::move(curve));
      error.curves.push_back(std::move(rms));
    }
    chart.panels.push_back(std::move(aborted));
    chart.panels.push_back(std::move(error));
  }
  figure.svg = report::DrawChart(chart);
  return figure;
}

void Compare(const Outcomes& bursts, Findings& findings) {
  for (std::size_t p = 0; p < kPaces.size(); ++p) {
    for (std::size_t w = 0; w < kWays.size(); ++w) {
      int aborted = 0;
      int runs = 0;
      for (const Outcome& outcome : bursts[p][w]) {
        aborted += outcome.aborted;
        runs += outcome.runs;
      }
      Comparison comparison{.quantity = fmt::format("{}, bursts of 1 to 19, {}: aborted, {} runs",
                                                    kPaces[p].name, kWays[w].name, runs),
                            .unit = "%",
                            .ours = 100.0 * aborted / runs};
      if (w == kOurs) {
        comparison.demand = "none";
        comparison.verdict = Judge(aborted == 0);
      }
      findings.comparisons.push_back(comparison);
    }
    const Outcome& longest = bursts[p][kOurs].back();
    findings.comparisons.push_back(
        {.quantity =
             fmt::format("{}, bursts of 19, ours: RMS error without its delay", kPaces[p].name),
         .unit = "mrad",
         .ours = longest.rms_mrad()});
  }
}

std::string Describe(int runs) {
  return fmt::format(
      "Commands are lost in runs of one length, {} a second in the mean, at instants that are the "
      "same for every way; or each for itself. Nothing else disturbs: no jitter, no drift, the "
      "ideal plant. {} runs of each. Canonical: a tenth of the acceleration limits; brisk: 0.6 of "
      "them and 0.8 of the speed limits; hard: 0.85 and 0.95. The paper's generator has the stall "
      "bridge behind it, as everywhere here. Where this matters and where not: on the canonical "
      "trajectory and up to 3 commands in a row, the paper's generator serves as well, without the "
      "delay of 2.25 ms that resampling costs; the guarantee is for longer runs of losses, motions "
      "near the limits, and limits of the position.",
      kBurstsPerSecond, runs);
}

}  // namespace

Findings RunLosses(const Setting& setting) {
  const int runs = std::min(setting.seeds, 3);
  std::vector<Loss> bursts;
  std::vector<double> lengths;
  bursts.reserve(kBursts.size());
  lengths.reserve(kBursts.size());
  for (const int burst : kBursts) {
    bursts.push_back({.burst = burst});
    lengths.push_back(burst);
  }
  std::vector<Loss> shares;
  shares.reserve(kShares.size());
  for (const double share : kShares) shares.push_back({.share_percent = share});
  const Outcomes by_burst = MeasureAll(setting, bursts, runs, 0, 0.55);
  const Outcomes by_share = MeasureAll(setting, shares, runs, 0.55, 1);
  Findings findings{.id = "losses",
                    .title = "Runs of lost commands",
                    .source = "left open by the paper (its outlook)",
                    .text = Describe(runs)};
  Compare(by_burst, findings);
  findings.figures = {
      Draw("bursts", "Bursts of losses",
           "Share of motions that the robot aborts, and the error of those completed, against the "
           "length of the bursts.",
           "commands lost in a row", lengths, by_burst),
      Draw("shares", "Losses one by one",
           "The same when each command is lost for itself: long runs are rare, until most are.",
           "lost commands [%]", {kShares.begin(), kShares.end()}, by_share)};
  return findings;
}

}  // namespace twin::experiment

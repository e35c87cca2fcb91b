#include "experiment/tracking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/loop_sample.h"
#include "experiment/recording.h"
#include "experiment/runs.h"
#include "experiment/tracking_figures.h"
#include "experiment/tracking_response.h"
#include "experiment/tracking_runs.h"
#include "experiment/tracking_sensitivity.h"
#include "twin/reference/low_pass.h"

namespace twin::experiment {
namespace {

using Outcome = TrackingOutcome;

constexpr double kUntilLevels = 0.4;  // of the work
constexpr int kMostRuns = 3;          // of each way; the runs on MuJoCo are what takes time here

/// Those that are compared by name.
constexpr std::array<std::pair<Way, const char*>, 2> kNamed{
    {{Way::kSynchronous, "synchronous"}, {Way::kProposed, "proposed"}}};

using Outcomes = std::array<std::vector<Outcome>, kWays>;

const std::vector<Outcome>& Of(const Outcomes& outcomes, Way way) {
  return outcomes[static_cast<std::size_t>(way)];
}

/// Band power of one way over that of the proposed, run by run.
std::vector<double> PowerRatios(const Outcomes& outcomes, Way way, std::size_t joint) {
  std::vector<double> ratios;
  const std::vector<Outcome>& proposed = Of(outcomes, Way::kProposed);
  for (std::size_t run = 0; run < Of(outcomes, way).size(); ++run) {
    ratios.push_back(Of(outcomes, way)[run].band[joint] / proposed[run].band[joint]);
  }
  return ratios;
}

/// The same of several joints, one after the other.
std::vector<double> PowerRatios(const Outcomes& outcomes, Way way, std::size_t first,
                                std::size_t last) {
  std::vector<double> all;
  for (std::size_t j = first; j <= last; ++j) {
    const std::vector<double> ratios = PowerRatios(outcomes, way, j);
    all.insert(all.end(), ratios.begin(), ratios.end());
  }
  return all;
}

/// A quantity of every joint and run of a way.
std::vector<double> Values(const std::vector<Outcome>& outcomes, JointVector Outcome::*field) {
  std::vector<double> values;
  for (const Outcome& outcome : outcomes) {
    const JointVector& joints = outcome.*field;
    values.insert(values.end(), joints.begin(), joints.end());
  }
  return values;
}

/// What the paper has about 10 of. Ours is far more, and why is known.
Comparison PaperPower(std::string quantity, const Spread& ratio) {
  constexpr double kLeast = 5;
  constexpr double kMost = 20;
  return {.quantity = std::move(quantity),
          .paper = 10,
          .ours = ratio.mean,
          .low = ratio.low,
          .high = ratio.high,
          .demand = fmt::format("{:g} to {:g} in every run", kLeast, kMost),
          .verdict = Judge(ratio.low >= kLeast && ratio.high <= kMost),
          .reason =
              "it is the power of the synchronous loop over that of the injected sensor noise, and "
              "hangs on how states spread on their way, which the paper does not tell: see where "
              "its 10 would come out"};
}

void ComparePower(const Outcomes& outcomes, std::vector<Comparison>& out) {
  const Spread first = SpreadOf(PowerRatios(outcomes, Way::kSynchronous, 0));
  out.push_back(PaperPower("Power of dq in 20-150 Hz, synchronous : proposed, joint 1", first));
  std::vector<double> medians;
  for (std::size_t run = 0; run < Of(outcomes, Way::kProposed).size(); ++run) {
    medians.push_back(Of(outcomes, Way::kSynchronous)[run].median_band /
                      Of(outcomes, Way::kProposed)[run].median_band);
  }
  const Spread median = SpreadOf(medians);
  out.push_back({"The same, the median second of the motion", "", 10, median.mean, median.low,
                 median.high, "", Verdict::kReported});
  const Spread others = SpreadOf(PowerRatios(outcomes, Way::kSynchronous, 1, kJoints - 1));
  out.push_back(PaperPower("Of the whole motion, the other joints", others));
  const Spread quiet = SpreadOf(PowerRatios(outcomes, Way::kQuiet, 0, kJoints - 1));
  out.push_back(
      {"Synchronous without jitter, drift and overruns : proposed, the largest of all joints",
       "",
       {},
       quiet.high,
       quiet.low,
       quiet.high,
       "",
       Verdict::kReported});
  const Spread filtered = SpreadOf(PowerRatios(outcomes, Way::kFiltered, 0));
  out.push_back({"Low-passed asynchronous : proposed, joint 1",
                 "",
                 {},
                 filtered.mean,
                 filtered.low,
                 filtered.high,
                 "",
                 Verdict::kReported});
  for (const auto& [way, name] : kNamed) {
    std::vector<double> rms;
    for (const Outcome& outcome : Of(outcomes, way))
      rms.push_back(1e3 * std::sqrt(outcome.band[0]));
    const Spread spread = SpreadOf(rms);
    out.push_back({fmt::format("RMS of dq in 20-150 Hz, {}, joint 1", name),
                   "mrad/s",
                   {},
                   spread.mean,
                   spread.low,
                   spread.high,
                   "",
                   Verdict::kReported});
  }
}

void CompareFollowing(const Outcomes& outcomes, const FollowedShare& share,
                      std::vector<Comparison>& out) {
  const Spread slope = SpreadOf(Values(Of(outcomes, Way::kFiltered), &Outcome::slope));
  out.push_back({"Low-passed asynchronous: slope of dq on the planned velocity, all joints",
                 "",
                 {},
                 slope.mean,
                 slope.low,
                 slope.high,
                 "0.38 to 0.60 on every joint",
                 Judge(slope.low >= 0.38 && slope.high <= 0.60)});
  const double error = 100 * share.largest_error();
  out.push_back(
      {"Its frequency response off g(s + lambda/T)/(s + g lambda/T), 0.05 to 5 Hz, the "
       "largest",
       "%",
       {},
       error,
       {},
       {},
       "at most 5 %",
       Judge(error <= 5)});
  for (const auto& [way, name] : kNamed) {
    const Spread followed = SpreadOf(Values(Of(outcomes, way), &Outcome::slope));
    out.push_back({fmt::format("Slope of dq on the planned velocity, {}, all joints", name),
                   "",
                   {},
                   followed.mean,
                   followed.low,
                   followed.high,
                   "",
                   Verdict::kReported});
  }
}

void CompareTracking(const Outcomes& outcomes, std::vector<Comparison>& out) {
  const std::vector<Outcome>& proposed = Of(outcomes, Way::kProposed);
  const Spread error = SpreadOf(Values(proposed, &Outcome::rms_delayed));
  out.push_back({"Proposed: RMS error of q after its delay, the largest of all joints",
                 "mrad",
                 {},
                 1e3 * error.high,
                 1e3 * error.low,
                 1e3 * error.high,
                 "at most 2 mrad",
                 Judge(error.high <= 2e-3)});
  const auto aborts =
      std::ranges::count_if(proposed, [](const Outcome& outcome) { return !outcome.succeeded; });
  out.push_back({fmt::format("Proposed: runs of {} that did not end well", proposed.size()),
                 "",
                 0,
                 static_cast<double>(aborts),
                 {},
                 {},
                 "none",
                 Judge(aborts == 0)});
  const Spread synchronous =
      SpreadOf(Values(Of(outcomes, Way::kSynchronous), &Outcome::rms_delayed));
  out.push_back({"Synchronous: the same error, the largest",
                 "mrad",
                 {},
                 1e3 * synchronous.high,
                 1e3 * synchronous.low,
                 1e3 * synchronous.high,
                 "",
                 Verdict::kReported});
  const Spread filtered = SpreadOf(Values(Of(outcomes, Way::kFiltered), &Outcome::rms));
  out.push_back({"Low-passed asynchronous: RMS error of q, the largest",
                 "mrad",
                 {},
                 1e3 * filtered.high,
                 1e3 * filtered.low,
                 1e3 * filtered.high,
                 "",
                 Verdict::kReported});
  std::vector<double> delays;
  delays.reserve(proposed.size());
  for (const Outcome& outcome : proposed) delays.push_back(1e3 * outcome.delay_s);
  const Spread delay = SpreadOf(delays);
  out.push_back({"Proposed: delay of q behind the plan, from the first cycle served",
                 "ms",
                 {},
                 delay.mean,
                 delay.low,
                 delay.high,
                 "",
                 Verdict::kReported});
}

Outcomes MeasureAll(const Setting& setting, const reference::Trajectory& plan,
                    FollowedShare& share) {
  const int runs = std::clamp(setting.seeds, 1, kMostRuns);
  Outcomes outcomes;
  std::vector<std::pair<Way, int>> jobs;
  for (std::size_t way = 0; way < kWays; ++way) {
    outcomes[way].resize(static_cast<std::size_t>(runs));
    for (int run = 0; run < runs; ++run) jobs.emplace_back(static_cast<Way>(way), run);
  }
  InParallel(
      setting, static_cast<int>(jobs.size()) + 1,
      [&](int i) {
        if (i == 0) {
          share = MeasureFollowedShare(setting, kLowPassHz);
          return;
        }
        const auto [way, run] = jobs[static_cast<std::size_t>(i) - 1];
        outcomes[static_cast<std::size_t>(way)][static_cast<std::size_t>(run)] =
            MeasureTracking(setting, plan, way, run);
      },
      0, kUntilLevels);
  return outcomes;
}

}  // namespace

Findings RunTrackingOnWallClock(const Setting& setting) {
  const reference::Trajectory plan = TrackingPlan(setting);
  constexpr std::array kWallWays{Way::kSynchronous, Way::kProposed, Way::kFiltered};
  Outcomes outcomes;
  InParallel(setting, static_cast<int>(kWallWays.size()), [&](int i) {
    const Way way = kWallWays[static_cast<std::size_t>(i)];
    outcomes[static_cast<std::size_t>(way)] = {MeasureTracking(setting, plan, way, 0)};
  });
  Findings findings;
  const auto report = [&](const char* quantity, const char* unit, std::optional<double> paper,
                          double ours) {
    findings.comparisons.push_back(
        {.quantity = quantity, .unit = unit, .paper = paper, .ours = ours});
  };
  report("Power of dq in 20-150 Hz, synchronous : proposed, joint 1", "", 10,
         PowerRatios(outcomes, Way::kSynchronous, 0).front());
  report("The same, low-passed asynchronous : proposed", "", {},
         PowerRatios(outcomes, Way::kFiltered, 0).front());
  const Spread error = SpreadOf(Values(Of(outcomes, Way::kProposed), &Outcome::rms_delayed));
  report("Proposed: RMS error of q after its delay, the largest of all joints", "mrad", {},
         1e3 * error.high);
  report("Low-passed asynchronous: slope of dq on the planned velocity, joint 1", "", {},
         Of(outcomes, Way::kFiltered).front().slope[0]);
  double ended = 0;
  for (const Way way : kWallWays) ended += Of(outcomes, way).front().succeeded ? 1 : 0;
  report("Runs of 3 that reached their goal", "", {}, ended);
  const auto curves = [&outcomes](Way way) {
    return std::move(outcomes[static_cast<std::size_t>(way)].front().curves);
  };
  const TrackingRuns runs{.planned = PlannedVelocities(plan),
                          .synchronous = curves(Way::kSynchronous),
                          .proposed = curves(Way::kProposed),
                          .filtered = curves(Way::kFiltered)};
  findings.figures = {FirstJointFigure(runs), VelocitiesFigure(runs)};
  return findings;
}

Findings RunTracking(const Setting& setting) {
  const reference::Trajectory plan = TrackingPlan(setting);
  FollowedShare share;
  Outcomes outcomes = MeasureAll(setting, plan, share);
  Findings findings{.values = {{"runs", fmt::format("{}", Of(outcomes, Way::kProposed).size())}}};
  ComparePower(outcomes, findings.comparisons);
  CompareFollowing(outcomes, share, findings.comparisons);
  CompareTracking(outcomes, findings.comparisons);
  const auto first = [&outcomes](Way way) {
    return std::move(outcomes[static_cast<std::size_t>(way)].front().curves);
  };
  const TrackingRuns runs{.planned = PlannedVelocities(plan),
                          .synchronous = first(Way::kSynchronous),
                          .proposed = first(Way::kProposed),
                          .filtered = first(Way::kFiltered),
                          .quiet = first(Way::kQuiet)};
  findings.figures = {FirstJointFigure(runs), VelocitiesFigure(runs), SpectraFigure(runs)};
  AddLevels(setting, plan, kUntilLevels, findings);
  const double lambda = LoadScenario(setting, "asynchronous").tick.lambda;
  findings.figures.push_back(
      FollowedShareFigure(share, reference::LowPass(kLowPassHz).gain(), lambda));
  return findings;
}

}  // namespace twin::experiment

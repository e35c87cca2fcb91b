#include "experiment/jitter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/jitter_parts.h"
#include "experiment/runs.h"

namespace twin::experiment {
namespace {

using control::CommandInterface;
using std::chrono::microseconds;

constexpr double kJitter = 4e-6;  // s, the paper's
constexpr double kPpm = 50;
constexpr int kRunsForEverySeed = 5;  // 100 runs with the usual 20 seeds

/// Ours beside the paper's, with what must hold.
Comparison Demanded(Comparison comparison, std::string demand, bool met) {
  comparison.demand = std::move(demand);
  comparison.verdict = Judge(met);
  return comparison;
}

/// One sample displaced in a motion at constant speed, as INT sees it.
double JerkOfOneSample(double speed, double displacement_s) {
  onboard::JointReference reference = onboard::JointReference::Rest({});
  reference.dq_d[0] = speed;
  double largest = 0;
  for (int k = 1; k <= 8; ++k) {
    const double t = k * kCycleSeconds + (k == 4 ? displacement_s : 0);
    reference = reference.AfterPosition({speed * t});
    largest = std::max(largest, std::abs(reference.dddq_d[0]));
  }
  return largest;
}

/// The reconstructed jerk beside its own expansion: so by arithmetic, and no demand.
void ShowFormula(const JitterJerk& jerk, const std::string& interface, Findings& findings) {
  findings.comparisons.push_back(
      {.quantity = interface + ": RMS of the jerk of jitter, reconstructed / formula",
       .paper = 1,
       .ours = jerk.ratio});
  findings.comparisons.push_back(
      {.quantity = interface + ": RMS of reconstructed - formula, of the formula's",
       .unit = "%",
       .ours = jerk.residual * 100});
}

/// What came of the canonical trajectory behind a remedy.
struct CanonicalRuns {
  int aborted = 0;
  double largest_jerk = 0;  ///< of all runs, as a share of its limit
};

CanonicalRuns RunCanonical(const Setting& setting, const StreamSetting& streams, Remedy remedy,
                           int runs, bool stops) {
  std::vector<StreamResult> results(static_cast<std::size_t>(runs));
  const auto job = [&](int run) {
    Stream stream = StreamBehind(remedy, streams.robot);
    stream.jitter_s = kJitter;
    stream.clock_ppm = run % 2 == 0 ? kPpm : -kPpm;
    stream.phase = FromSeconds(kCycleSeconds * ChoiceOfRun(setting, run));
    stream.seed = SeedOfRun(setting, run);
    results[static_cast<std::size_t>(run)] =
        RunStream(streams.canonical, streams.robot.limits, stream, stops);
  };
  InParallel(setting, runs, job, 0, 0.2);
  CanonicalRuns all;
  for (const StreamResult& result : results) {
    all.aborted += result.aborted ? 1 : 0;
    all.largest_jerk = std::max(all.largest_jerk, Largest(result.jerk));
  }
  return all;
}

/// The same through the whole stack in lockstep. @returns how many of the runs aborted.
int AbortsThroughStack(const Setting& setting, loop::Generator generator, int runs) {
  return CountFailures(
      setting, runs,
      [&](scenario::Scenario& scenario) {
        scenario.link.state = {};
        scenario.link.command = {};
        scenario.link.state.delay.law = rt::ConstantDelay{microseconds(80)};
        scenario.controller.cost.law = rt::ConstantDelay{microseconds(60)};
        scenario.controller.wake_delay.law = rt::NormalDelay{microseconds(20), microseconds(4)};
        scenario.tick.limiter = false;
        scenario.tick.generator = generator;
      },
      0.2, 0.3);
}

void CompareCanonical(const Setting& setting, const StreamSetting& streams, Findings& findings) {
  const int runs = kRunsForEverySeed * setting.seeds;
  const std::string of = fmt::format("{} runs of the canonical trajectory, 4 us: ", runs);
  const CanonicalRuns raw = RunCanonical(setting, streams, Remedy::kNone, runs, true);
  findings.comparisons.push_back(Demanded({.quantity = of + "raw stream aborts",
                                           .unit = "%",
                                           .paper = 100,
                                           .ours = 100.0 * raw.aborted / runs},
                                          "all of them", raw.aborted == runs));
  const CanonicalRuns generator = RunCanonical(setting, streams, Remedy::kGenerator, runs, false);
  findings.comparisons.push_back(Demanded({.quantity = of + "reference generator aborts",
                                           .unit = "%",
                                           .paper = 0,
                                           .ours = 100.0 * generator.aborted / runs},
                                          "none", generator.aborted == 0));
  findings.comparisons.push_back({.quantity = of + "largest jerk / limit, reference generator",
                                  .ours = generator.largest_jerk});
  const int whole = std::min(setting.seeds, 4);
  const int raw_aborts = AbortsThroughStack(setting, loop::Generator::kNone, whole);
  const int aborts = AbortsThroughStack(setting, loop::Generator::kJoint, whole);
  findings.comparisons.push_back(Demanded(
      {.quantity =
           fmt::format("the same through the whole stack, {} runs: raw stream aborts", whole),
       .unit = "%",
       .paper = 100,
       .ours = 100.0 * raw_aborts / whole},
      "all of them", raw_aborts == whole));
  findings.comparisons.push_back(
      Demanded({.quantity = fmt::format("the same, {} runs: reference generator aborts", whole),
                .unit = "%",
                .paper = 0,
                .ours = 100.0 * aborts / whole},
               "none", aborts == 0));
}

/// How much each remedy leaves of the jerk of jitter, without a crossing of the clocks.
void CompareRemedies(const Setting& setting, const StreamSetting& streams, Findings& findings) {
  for (std::size_t way = 0; way < kRemedyNames.size(); ++way) {
    Stream stream = StreamBehind(static_cast<Remedy>(way), streams.robot);
    stream.jitter_s = kJitter;
    stream.seed = setting.seed;
    const StreamResult result = RunStream(streams.canonical, streams.robot.limits, stream, false);
    findings.comparisons.push_back(
        {.quantity = fmt::format("canonical, 4 us, {}: RMS jerk / limit, worst joint, as though "
                                 "INT went on",
                                 kRemedyNames[way]),
         .ours = Largest(result.rms_jerk)});
  }
}

void CompareEnd(const std::vector<Pace>& paces, Findings& findings) {
  struct Known {
    double acceleration;
    double jerk;
  };
  // Of another implementation, of one joint behind a simple servo.
  constexpr Known kOther[] = {{0.21, 0.72}, {0.27, 1.23}, {0.68, 2.85}};
  for (const Known& known : kOther) {
    const auto pace = std::ranges::min_element(paces, {}, [&](const Pace& candidate) {
      return std::abs(candidate.acceleration - known.acceleration);
    });
    findings.comparisons.push_back(
        {.quantity = fmt::format("brisk, |ddq| {:.2f} of its limit: largest jerk / limit (another "
                                 "implementation: {})",
                                 known.acceleration, known.jerk),
         .ours = pace->jerk});
  }
  findings.comparisons.push_back(
      {.quantity = "brisk: |ddq| / limit up to which the reference generator keeps the jerk limit",
       .ours = ShareAtLimit(paces)});
}

}  // namespace

Findings RunJitter(const Setting& setting) {
  const StreamSetting streams = LoadStreamSetting(setting);
  const JointLimits& limits = streams.robot.limits;
  Findings findings{
      .values = {{"runs", fmt::format("{}", setting.seeds)}, {"ppm", fmt::format("{}", kPpm)}}};
  findings.comparisons.push_back({.quantity = "one sample displaced by 4 us at 1 rad/s: jerk",
                                  .unit = "rad/s^3",
                                  .paper = 1.2e4,
                                  .ours = JerkOfOneSample(1, kJitter)});
  const JitterJerk position = JerkOfJitter(streams.canonical, limits,
                                           CommandInterface::kJointPosition, kJitter, setting.seed);
  const JitterJerk velocity = JerkOfJitter(streams.canonical, limits,
                                           CommandInterface::kJointVelocity, kJitter, setting.seed);
  ShowFormula(position, "position interface", findings);
  ShowFormula(velocity, "velocity interface", findings);
  CompareCanonical(setting, streams, findings);
  CompareRemedies(setting, streams, findings);
  const AbortMap map = MapAborts(setting, streams.robot, {0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64},
                                 {0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2}, setting.seeds);
  const std::vector<Pace> paces = FindEnd(
      setting, streams, {0.1, 0.15, 0.21, 0.24, 0.27, 0.35, 0.45, 0.55, 0.68}, setting.seeds);
  CompareEnd(paces, findings);
  findings.figures = {SamplesFigure(streams.robot, setting.seed),
                      JitterJerkFigure(position, velocity), AbortMapFigure(map, limits),
                      EndFigure(paces, limits)};
  return findings;
}

}  // namespace twin::experiment

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "experiment/statistics.h"
#include "experiment/stream.h"
#include "experiment/studies.h"

namespace twin::experiment {
namespace {

using std::chrono::microseconds;

constexpr int kRunsPerSeed = 5;        // 100 runs with the usual 20 seeds
constexpr int kMostWallClockRuns = 3;  // of each generator: 18 s a run

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

/// Runs of the canonical trajectory behind a remedy.
StreamRuns RunCanonicalStreams(const Config& config, const StreamInputs& inputs, Remedy remedy,
                               int runs, bool stops) {
  return SummaryOf(MapInParallel(
      config, runs,
      [&](int run) {
        const double ppm = run % 2 == 0 ? kFreeRunningPpm : -kFreeRunningPpm;
        return RunStream(inputs.canonical, inputs.robot.limits,
                         StreamOfRun(config, remedy, inputs.robot, kPaperJitter, ppm, run), stops);
      },
      0, 0.2));
}

/// The same through the whole stack in lockstep. @returns the share of aborted runs.
double JitterAbortsThroughStack(const Config& config, loop::Generator generator, int runs) {
  const int aborted = CountFailures(
      config, runs,
      [&](scenario::Scenario& scenario) {
        scenario.link.state = {};
        scenario.link.command = {};
        scenario.link.state.delay = ConstantDelay(80);
        scenario.controller.cost = ConstantDelay(60);
        scenario.controller.wake_delay.law = faults::NormalDelay{microseconds(20), microseconds(4)};
        scenario.tick.limiter = false;
        scenario.tick.generator = generator;
      },
      0.2, 0.3);
  return static_cast<double>(aborted) / runs;
}

void CompareCanonical(const Config& config, const StreamInputs& inputs, Findings& findings) {
  const auto add = [&](std::string quantity, double aborted, bool all_abort) {
    findings.Add(std::move(quantity), "%", 100 * aborted)
        .Paper(all_abort ? 100 : 0)
        .Demand(all_abort ? "all of them" : "none", aborted == (all_abort ? 1 : 0));
  };
  const int runs = kRunsPerSeed * config.seeds;
  const std::string of = fmt::format("{} runs of the canonical trajectory, 4 us: ", runs);
  add(of + "raw stream aborts",
      RunCanonicalStreams(config, inputs, Remedy::kNone, runs, true).aborted, true);
  const StreamRuns generator = RunCanonicalStreams(config, inputs, Remedy::kGenerator, runs, false);
  add(of + "reference generator aborts", generator.aborted, false);
  findings.Add(of + "largest jerk / limit, reference generator", "", generator.jerk);
  const int whole = std::min(config.seeds, 4);
  add(fmt::format("the same through the whole stack, {} runs: raw stream aborts", whole),
      JitterAbortsThroughStack(config, loop::Generator::kNone, whole), true);
  add(fmt::format("the same, {} runs: reference generator aborts", whole),
      JitterAbortsThroughStack(config, loop::Generator::kJoint, whole), false);
}

/// The share of the jerk of jitter that each remedy leaves, without a crossing of the clocks.
void CompareRemedies(const Config& config, const StreamInputs& inputs, Findings& findings) {
  for (std::size_t i = 0; i < kRemedyNames.size(); ++i) {
    Stream stream = StreamBehind(static_cast<Remedy>(i), inputs.robot);
    stream.jitter_s = kPaperJitter;
    stream.seed = config.seed;
    const StreamResult result = RunStream(inputs.canonical, inputs.robot.limits, stream, false);
    findings.Add(fmt::format("canonical, 4 us, {}: RMS jerk / limit, worst joint, as though INT "
                             "went on",
                             kRemedyNames[i]),
                 "", Largest(result.rms_jerk));
  }
}

void CompareEnd(const std::vector<PaceResult>& paces, Findings& findings) {
  struct Known {
    double acceleration;
    double jerk;
  };
  // Of another implementation, of one joint behind a simple servo.
  constexpr Known kOther[] = {{0.21, 0.72}, {0.27, 1.23}, {0.68, 2.85}};
  for (const Known& known : kOther) {
    const auto pace = std::ranges::min_element(paces, {}, [&](const PaceResult& candidate) {
      return std::abs(candidate.acceleration - known.acceleration);
    });
    findings.Add(fmt::format("brisk, |ddq| {:.2f} of its limit: largest jerk / limit (another "
                             "implementation: {})",
                             known.acceleration, known.jerk),
                 "", pace->jerk);
  }
  findings.Add("brisk: |ddq| / limit up to which the reference generator keeps the jerk limit", "",
               ShareAtLimit(paces));
}

/// Difference of each interval between deposits from whole cycles, us, rising. Deposits that no
/// tick consumed do not count.
std::vector<double> OffCycle(const std::vector<TickSample>& ticks) {
  std::vector<double> off;
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    const double interval_us = 1e6 * ToSeconds(ticks[i].deposit_time - ticks[i - 1].deposit_time);
    if (interval_us == 0) continue;
    const double cycles = std::max(1.0, std::round(interval_us / 1e3));
    off.push_back(std::abs(interval_us - 1e3 * cycles));
  }
  std::ranges::sort(off);
  return off;
}

/// Aborted runs, and the jitter of runs with deposits.
struct JitteredRuns {
  int runs = 0;
  int aborted = 0;
  std::vector<double> median_us{};
  std::vector<double> p99_us{};
};

JitteredRuns RunJittered(const Config& config, loop::Generator generator) {
  JitteredRuns all{.runs = std::min(config.seeds, kMostWallClockRuns)};
  InParallel(config, all.runs, [&](int run) {
    scenario::Scenario scenario = LoadScenario(config, "asynchronous", run);
    scenario.tick.limiter = false;
    scenario.tick.generator = generator;
    Recording recording;
    if (!RunScenario(config, scenario, &recording).report.succeeded()) ++all.aborted;
    const std::vector<double> off = OffCycle(recording.ticks());
    if (off.empty()) return;
    all.median_us.push_back(Percentile(off, 0.5));
    all.p99_us.push_back(Percentile(off, 0.99));
  });
  return all;
}

constexpr double kSpeed = 1;  // of the figure of samples, rad/s

/// A close-up of samples displaced, as planned and as filed. Its jitter is 40 times as large, to be
/// visible.
report::Table DisplacedSamples(const reference::Trajectory& plan, const JointLimits& limits,
                               Stream stream) {
  constexpr std::size_t kBegin = 494;
  constexpr std::size_t kEnd = 507;
  stream.jitter_s = 160e-6;
  const std::vector<onboard::JointReference> raw = ReferencesOf(plan, limits, stream);
  const double q0 = plan.Sample(FromSeconds(0.5)).q[0];
  report::Table table{.columns = "filed at [ms],sampled at [ms],intended [mrad],sampled [mrad]"};
  for (std::size_t i = kBegin; i < kEnd; ++i) {
    const double t = static_cast<double>(i) * kT;
    table.rows.push_back({t * 1e3, (t + ToSeconds(SamplingError(stream, i))) * 1e3,
                          (plan.Sample(FromSeconds(t)).q[0] - q0) * 1e3,
                          (raw[i].q_d[0] - q0) * 1e3});
  }
  return table;
}

/// One edge of the cone: the acceleration changes by `jerk` until its limit. @returns the
/// increment, rad, of the n-th cycle after `from`.
double ConeEdge(const onboard::JointReference& from, const JointLimits& limits, double jerk,
                int n) {
  double velocity = from.dq_d[0];
  double acceleration = from.ddq_d[0];
  for (int i = 0; i < n; ++i) {
    acceleration = std::clamp(acceleration + jerk * kT, -limits.ddq_max[0], limits.ddq_max[0]);
    velocity += acceleration * kT;
  }
  return velocity * kT;
}

/// One sample 4 us late in a motion at constant speed: the next increment leaves the cone of
/// admissible ones.
report::Table Cone(const JointLimits& limits) {
  constexpr int kLate = 5;
  constexpr double kIntended = kSpeed * kT;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  onboard::JointReference reference = onboard::JointReference::Rest({});
  onboard::JointReference late;
  reference.dq_d[0] = kSpeed;
  report::Table table{.columns = "cycle,increment [urad],least [urad],most [urad],refused [urad]"};
  for (int k = 1; k <= kLate + 2; ++k) {
    const double t = k * kT + (k == kLate ? kPaperJitter : 0);
    reference = reference.AfterPosition({kSpeed * t});
    if (k == kLate) late = reference;
    const auto edge = [&](double jerk) {
      if (k < kLate) return kNone;
      return (ConeEdge(late, limits, jerk, k - kLate) - kIntended) * 1e6;
    };
    const double increment = (reference.dq_d[0] * kT - kIntended) * 1e6;
    table.rows.push_back({static_cast<double>(k), increment, edge(-limits.dddq_max[0]),
                          edge(limits.dddq_max[0]), k == kLate + 1 ? increment : kNone});
  }
  return table;
}

Figure SamplesFigure(const scenario::RobotData& robot, std::uint64_t seed) {
  const reference::Trajectory plan = SecondOfMotion({kSpeed / kPeakOfSecond}, robot.limits);
  Stream stream = StreamBehind(Remedy::kNone, robot);
  stream.seed = seed;
  stream.jitter_s = kPaperJitter;
  const std::vector<onboard::JointReference> raw = ReferencesOf(plan, robot.limits, stream);
  Figure figure{.id = "samples",
                .columns =
                    "t [s],sampling error [s],intended q [rad],reconstructed q [rad],"
                    "reconstructed dq [rad/s],reconstructed ddq [rad/s^2]",
                .tables = {{"displaced", DisplacedSamples(plan, robot.limits, stream)},
                           {"cone", Cone(robot.limits)}}};
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const double t = static_cast<double>(i) * kT;
    figure.rows.push_back({t, ToSeconds(SamplingError(stream, i)), plan.Sample(FromSeconds(t)).q[0],
                           raw[i].q_d[0], raw[i].dq_d[0], raw[i].ddq_d[0]});
  }
  return figure;
}

Figure JitterJerkFigure(const JitterJerk& position, const JitterJerk& velocity) {
  return FigureOf("jerk", {{"t [s]", position.t},
                           {"position measured [rad/s^3]", position.measured[0]},
                           {"position formula [rad/s^3]", position.formula[0]},
                           {"velocity measured [rad/s^3]", velocity.measured[0]},
                           {"velocity formula [rad/s^3]", velocity.formula[0]}});
}

Figure AbortMapFigure(const AbortMap& map, const JointLimits& limits) {
  Figure figure{
      .id = "map",
      .columns = fmt::format("jitter [us],peak speed [rad/s],{}", fmt::join(kRemedyNames, ",")),
      .values = {{"runs", map.runs}, {"jerk_limit", limits.dddq_max[0]}},
      .names = {kRemedyNames.begin(), kRemedyNames.end()}};
  for (std::size_t i = 0; i < map.probability.size(); ++i) {
    std::vector<double>& row = figure.rows.emplace_back(
        std::vector{map.jitter_us[i % map.jitter_us.size()], map.speed[i / map.jitter_us.size()]});
    row.insert(row.end(), map.probability[i].begin(), map.probability[i].end());
  }
  return figure;
}

Figure EndFigure(const std::vector<PaceResult>& paces, const JointLimits& limits) {
  Figure figure{.id = "end",
                .columns = "largest ddq / its limit,largest jerk / its limit,share of runs aborted",
                .values = {{"limit_ratio", limits.ddq_max[0] / limits.dddq_max[0]}}};
  for (const PaceResult& pace : paces) {
    figure.rows.push_back({pace.acceleration, pace.jerk, pace.aborted});
  }
  return figure;
}

}  // namespace

Findings RunJitterOnWallClock(const Config& config) {
  const JitteredRuns raw = RunJittered(config, loop::Generator::kNone);
  const JitteredRuns generated = RunJittered(config, loop::Generator::kJoint);
  Findings findings;
  findings
      .Add(fmt::format("raw stream: aborts in {} runs", raw.runs), "%",
           100.0 * raw.aborted / raw.runs)
      .Paper(100);
  findings
      .Add(fmt::format("reference generator: aborts in {} runs", generated.runs), "%",
           100.0 * generated.aborted / generated.runs)
      .Paper(0);
  findings.Add("from one sample to the next, off a cycle: median", "us",
               SpreadOf(generated.median_us));
  findings.Add("the same, p99", "us", SpreadOf(generated.p99_us));
  return findings;
}

Findings RunJitter(const Config& config) {
  using control::CommandInterface;
  const StreamInputs inputs = LoadStreamInputs(config);
  const JointLimits& limits = inputs.robot.limits;
  Findings findings{.values = {{"runs", fmt::format("{}", config.seeds)},
                               {"ppm", fmt::format("{}", kFreeRunningPpm)}}};
  findings
      .Add("one sample displaced by 4 us at 1 rad/s: jerk", "rad/s^3",
           JerkOfOneSample(1, kPaperJitter))
      .Paper(1.2e4);
  // The reconstructed jerk beside its own expansion holds by arithmetic: no demand.
  const auto measure = [&](CommandInterface interface, const std::string& name) {
    JitterJerk jerk = JerkOfJitter(inputs.canonical, limits, interface, kPaperJitter, config.seed);
    findings.Add(name + ": RMS of the jerk of jitter, reconstructed / formula", "", jerk.ratio)
        .Paper(1);
    findings.Add(name + ": RMS of reconstructed - formula, of the formula's", "%",
                 jerk.residual * 100);
    return jerk;
  };
  const JitterJerk position = measure(CommandInterface::kJointPosition, "position interface");
  const JitterJerk velocity = measure(CommandInterface::kJointVelocity, "velocity interface");
  CompareCanonical(config, inputs, findings);
  CompareRemedies(config, inputs, findings);
  const AbortMap map = MapAborts(config, inputs.robot, {0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64},
                                 {0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2}, config.seeds);
  const std::vector<PaceResult> paces = MeasurePaces(
      config, inputs, {0.1, 0.15, 0.21, 0.24, 0.27, 0.35, 0.45, 0.55, 0.68}, config.seeds);
  CompareEnd(paces, findings);
  findings.figures = {SamplesFigure(inputs.robot, config.seed),
                      JitterJerkFigure(position, velocity), AbortMapFigure(map, limits),
                      EndFigure(paces, limits)};
  return findings;
}

}  // namespace twin::experiment

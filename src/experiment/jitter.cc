#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "experiment/runs.h"
#include "experiment/statistics.h"
#include "experiment/stream_studies.h"
#include "experiment/studies.h"

namespace twin::experiment {
namespace {

using std::chrono::microseconds;

constexpr double kDriftPpm = 50;
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
struct CanonicalRuns {
  int aborted = 0;
  double largest_jerk = 0;  ///< of all runs, as a share of its limit
};

CanonicalRuns RunCanonicalStreams(const Config& config, const StreamInputs& inputs, Remedy remedy,
                                  int runs, bool stops) {
  const auto run_once = [&](int run) {
    Stream stream = StreamBehind(remedy, inputs.robot);
    stream.jitter_s = kPaperJitter;
    stream.clock_ppm = run % 2 == 0 ? kDriftPpm : -kDriftPpm;
    stream.phase = PhaseOfRun(config, run);
    stream.seed = SeedOfRun(config, run);
    return RunStream(inputs.canonical, inputs.robot.limits, stream, stops);
  };
  CanonicalRuns all;
  for (const StreamResult& result : MapInParallel(config, runs, run_once, 0, 0.2)) {
    all.aborted += result.aborted ? 1 : 0;
    all.largest_jerk = std::max(all.largest_jerk, Largest(result.jerk));
  }
  return all;
}

/// The same through the whole stack in lockstep. @returns how many of the runs aborted.
int JitterAbortsThroughStack(const Config& config, loop::Generator generator, int runs) {
  return CountFailures(
      config, runs,
      [&](scenario::Scenario& scenario) {
        scenario.link.state = {};
        scenario.link.command = {};
        scenario.link.state.delay.law = faults::ConstantDelay{microseconds(80)};
        scenario.controller.cost.law = faults::ConstantDelay{microseconds(60)};
        scenario.controller.wake_delay.law = faults::NormalDelay{microseconds(20), microseconds(4)};
        scenario.tick.limiter = false;
        scenario.tick.generator = generator;
      },
      0.2, 0.3);
}

void CompareCanonical(const Config& config, const StreamInputs& inputs, Findings& findings) {
  const auto add = [&](std::string quantity, int aborted, int runs, bool all_abort) {
    findings.Add(std::move(quantity), "%", 100.0 * aborted / runs)
        .Paper(all_abort ? 100 : 0)
        .Demand(all_abort ? "all of them" : "none", aborted == (all_abort ? runs : 0));
  };
  const int runs = kRunsPerSeed * config.seeds;
  const std::string of = fmt::format("{} runs of the canonical trajectory, 4 us: ", runs);
  const CanonicalRuns raw = RunCanonicalStreams(config, inputs, Remedy::kNone, runs, true);
  add(of + "raw stream aborts", raw.aborted, runs, true);
  const CanonicalRuns generator =
      RunCanonicalStreams(config, inputs, Remedy::kGenerator, runs, false);
  add(of + "reference generator aborts", generator.aborted, runs, false);
  findings.Add(of + "largest jerk / limit, reference generator", "", generator.largest_jerk);
  const int whole = std::min(config.seeds, 4);
  add(fmt::format("the same through the whole stack, {} runs: raw stream aborts", whole),
      JitterAbortsThroughStack(config, loop::Generator::kNone, whole), whole, true);
  add(fmt::format("the same, {} runs: reference generator aborts", whole),
      JitterAbortsThroughStack(config, loop::Generator::kJoint, whole), whole, false);
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

/// Collects the source times of the consumed deposits.
class DepositTimes final : public record::RecordSink {
 public:
  DepositTimes() { times_.reserve(32768); }
  void Put(const record::CycleRecord& /*record*/) noexcept override {}
  void Put(const record::TickRecord& record) noexcept override {
    if (record.action != record::TickAction::kWritten) return;
    if (times_.empty() || times_.back() != record.deposit_time) {
      times_.push_back(record.deposit_time);
    }
  }

  /// Difference of each interval from whole cycles, us, rising. Deposits that no tick consumed do
  /// not count.
  [[nodiscard]] std::vector<double> OffCycle() const {
    std::vector<double> off;
    for (std::size_t i = 1; i < times_.size(); ++i) {
      const double interval_us = 1e6 * ToSeconds(times_[i] - times_[i - 1]);
      const double cycles = std::max(1.0, std::round(interval_us / 1e3));
      off.push_back(std::abs(interval_us - 1e3 * cycles));
    }
    std::ranges::sort(off);
    return off;
  }

 private:
  std::vector<Time> times_;
};

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
    scenario::Scenario scenario = LoadScenario(config, "asynchronous");
    scenario.seed = SeedOfRun(config, run);
    scenario.tick.limiter = false;
    scenario.tick.generator = generator;
    DepositTimes times;
    if (!RunScenario(config, scenario, &times).report.succeeded()) ++all.aborted;
    const std::vector<double> off = times.OffCycle();
    if (off.empty()) return;
    all.median_us.push_back(Percentile(off, 0.5));
    all.p99_us.push_back(Percentile(off, 0.99));
  });
  return all;
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
  Findings findings{
      .values = {{"runs", fmt::format("{}", config.seeds)}, {"ppm", fmt::format("{}", kDriftPpm)}}};
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

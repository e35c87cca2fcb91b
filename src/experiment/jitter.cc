#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "experiment/stream.h"
#include "experiment/studies.h"

namespace twin::experiment {
namespace {

constexpr int kRunsPerSeed = 5;        // 100 runs with the usual 20 seeds
constexpr int kMostWallClockRuns = 3;  // of each generator: 18 s a run
constexpr std::array<double, 10> kJittersUs{0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64};
constexpr std::array<double, 8> kSpeeds{0.25, 0.5, 0.75, 1,
                                        1.25, 1.5, 1.75, 2};  // rad/s, of the map

/// Backward difference of the sampling errors at deposit i, s.
double Difference(const Stream& stream, std::size_t i, int order) {
  if (order == 0) return ToSeconds(SamplingError(stream, i));
  return Difference(stream, i, order - 1) - Difference(stream, i - 1, order - 1);
}

double SumOfSquares(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
}

/// @returns INT's references behind a stream, cycle by cycle.
std::vector<onboard::JointReference> ReferencesOf(const reference::Trajectory& plan,
                                                  const JointLimits& limits, const Stream& stream) {
  std::vector<onboard::JointReference> references;
  static_cast<void>(RunStream(plan, limits, stream, false,
                              [&](std::uint64_t /*k*/, const onboard::JointReference& next) {
                                references.push_back(next);
                              }));
  return references;
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

/// Runs of the canonical trajectory behind a remedy.
StreamRuns RunCanonicalStreams(const Config& config, const StreamInputs& inputs, Remedy remedy,
                               int runs, bool stops) {
  return SummaryOf(MapInParallel(PartOf(config, 0, 0.2), runs, [&](int run) {
    const double ppm = run % 2 == 0 ? kFreeRunningPpm : -kFreeRunningPpm;
    return RunStream(inputs.canonical, inputs.robot.limits,
                     StreamOfRun(config, remedy, inputs.robot, kPaperJitter, ppm, run), stops);
  }));
}

/// The same through the whole stack in lockstep. @returns the share of aborted runs.
double JitterAbortsThroughStack(const Config& config, loop::Generator generator, int runs) {
  return FailedShare(PartOf(config, 0.2, 0.3), runs, [&](scenario::Scenario& scenario) {
    scenario.link.state = {};
    scenario.link.command = {};
    scenario.link.state.delay = ConstantDelay(80);
    scenario.controller.cost = ConstantDelay(60);
    scenario.controller.wake_delay.law =
        faults::NormalDelay{std::chrono::microseconds(20), std::chrono::microseconds(4)};
    scenario.tick.limiter = false;
    scenario.tick.generator = generator;
  });
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

void AddPaces(const std::vector<PaceResult>& paces, const JointLimits& limits, Findings& findings) {
  // Of another implementation, of one joint behind a simple servo.
  constexpr std::array kOther{PaceResult{0.21, 0.72}, PaceResult{0.27, 1.23},
                              PaceResult{0.68, 2.85}};
  for (const PaceResult& known : kOther) {
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
  Figure figure{.id = "end",
                .columns = "largest ddq / its limit,largest jerk / its limit,share of runs aborted",
                .values = {{"limit_ratio", limits.ddq_max[0] / limits.dddq_max[0]}}};
  for (const PaceResult& pace : paces) {
    figure.rows.push_back({pace.acceleration, pace.jerk, pace.aborted});
  }
  findings.figures.push_back(std::move(figure));
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

constexpr double kSpeed = 1;  // of the figure of samples, rad/s

/// A close-up of displaced samples, planned and filed. Its jitter is 40 times as large, to show.
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

Figure AbortMapFigure(const AbortMap& map, int runs, const JointLimits& limits) {
  Figure figure{
      .id = "map",
      .columns = fmt::format("jitter [us],peak speed [rad/s],{}", fmt::join(kRemedyNames, ",")),
      .values = {{"runs", runs}, {"jerk_limit", limits.dddq_max[0]}},
      .names = {kRemedyNames.begin(), kRemedyNames.end()}};
  for (std::size_t i = 0; i < map.all.size(); ++i) {
    std::vector<double>& row = figure.rows.emplace_back(
        std::vector{kJittersUs[i % map.columns], kSpeeds[i / map.columns]});
    row.insert(row.end(), map.all[i].begin(), map.all[i].end());
  }
  return figure;
}

}  // namespace

JitterJerk JerkOfJitter(const reference::Trajectory& plan, const JointLimits& limits,
                        control::CommandInterface interface, double jitter_s, std::uint64_t seed) {
  Stream stream{.interface = interface, .velocity = VelocityFrom::kGiven, .seed = seed};
  const std::vector<onboard::JointReference> exact = ReferencesOf(plan, limits, stream);
  stream.jitter_s = jitter_s;
  const std::vector<onboard::JointReference> jittered = ReferencesOf(plan, limits, stream);
  const bool is_position = interface == control::CommandInterface::kJointPosition;
  const int order = is_position ? 3 : 2;
  const auto planned = static_cast<std::size_t>(plan.duration() / kCycle);
  JitterJerk result;
  for (std::size_t i = 3; i < std::min({planned, exact.size(), jittered.size()}); ++i) {
    const double middle = (static_cast<double>(i) - 0.5 * order) * kT;
    const reference::JointTarget target = plan.Sample(FromSeconds(middle));
    const double factor = Difference(stream, i, order) / std::pow(kT, order);
    result.t.push_back(static_cast<double>(i) * kT);
    for (std::size_t j = 0; j < kJoints; ++j) {
      result.measured[j].push_back(jittered[i].dddq_d[j] - exact[i].dddq_d[j]);
      result.formula[j].push_back((is_position ? target.dq[j] : target.ddq[j]) * factor);
    }
  }
  double measured = 0;
  double formula = 0;
  double difference = 0;
  for (std::size_t j = 0; j < kJoints; ++j) {
    measured += SumOfSquares(result.measured[j]);
    formula += SumOfSquares(result.formula[j]);
    for (std::size_t i = 0; i < result.t.size(); ++i) {
      difference += std::pow(result.measured[j][i] - result.formula[j][i], 2);
    }
  }
  result.residual = std::sqrt(difference / formula);
  result.ratio = std::sqrt(measured / formula);
  return result;
}

AbortMap MapAborts(const Config& config, const scenario::RobotData& robot,
                   std::span<const double> jitter_us, std::span<const double> speed, int runs) {
  return MapGrid(config, speed.size(), jitter_us.size(), [&](std::size_t row, std::size_t column) {
    const auto plan = SecondOfMotion({speed[row] / kPeakOfSecond}, robot.limits);
    const int first = static_cast<int>(row * jitter_us.size() + column) * runs;
    AbortShares shares{};
    for (std::size_t remedy = 0; remedy < shares.size(); ++remedy) {
      std::vector<StreamResult> results;
      do {
        const Stream stream =
            StreamOfRun(config, static_cast<Remedy>(remedy), robot, jitter_us[column] * 1e-6,
                        kFreeRunningPpm, first + static_cast<int>(results.size()));
        results.push_back(RunStream(plan, robot.limits, stream, true));
        if (stream.on_robot_time) break;  // nothing in it is random
      } while (static_cast<int>(results.size()) < runs);
      shares[remedy] = SummaryOf(results).aborted;
    }
    return shares;
  });
}

std::vector<PaceResult> MeasurePaces(const Config& config, const StreamInputs& inputs,
                                     const std::vector<double>& shares, int runs) {
  const JointLimits& limits = inputs.robot.limits;
  std::vector<reference::Trajectory> plans;
  plans.reserve(shares.size());
  for (const double share : shares) plans.push_back(BriskAt(config, limits, share));
  const auto measure = [&](std::size_t pace, std::size_t run) {
    const int number = static_cast<int>(pace) * runs + static_cast<int>(run);
    Stream stream = StreamOfRun(config, Remedy::kGenerator, inputs.robot, kPaperJitter,
                                kFreeRunningPpm, number);
    stream.phase = PhaseOfOvertaking(plans[pace], kFreeRunningPpm, ChoiceOfRun(config, number));
    return RunStream(plans[pace], limits, stream, false);
  };
  const Grid<StreamResult> results = MapGrid(config, shares.size(), runs, measure);
  std::vector<PaceResult> paces;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const StreamRuns all = SummaryOf(results[i]);
    paces.push_back({Largest(plans[i].peaks().acceleration), all.jerk, all.aborted});
  }
  return paces;
}

double ShareAtLimit(const std::vector<PaceResult>& paces) noexcept {
  for (std::size_t i = 1; i < paces.size(); ++i) {
    const PaceResult& below = paces[i - 1];
    const PaceResult& above = paces[i];
    if (below.jerk > 1 || above.jerk <= 1) continue;
    return below.acceleration +
           (above.acceleration - below.acceleration) * (1 - below.jerk) / (above.jerk - below.jerk);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

Findings RunJitterOnWallClock(const Config& config) {
  const int runs = std::min(config.seeds, kMostWallClockRuns);
  Findings findings;
  std::vector<double> median_us;
  std::vector<double> p99_us;
  const auto measure = [&](const char* name, loop::Generator generator, double paper) {
    int aborted = 0;
    InParallel(config, runs, [&](int run) {
      scenario::Scenario scenario = LoadScenario(config, "asynchronous", run);
      scenario.tick.limiter = false;
      scenario.tick.generator = generator;
      Recording recording;
      if (!RunScenario(config, scenario, &recording).report.succeeded()) ++aborted;
      const std::vector<double> off = OffCycle(recording.ticks());
      if (off.empty() || generator == loop::Generator::kNone) return;
      median_us.push_back(Percentile(off, 0.5));
      p99_us.push_back(Percentile(off, 0.99));
    });
    findings.Add(fmt::format("{}: aborts in {} runs", name, runs), "%", 100.0 * aborted / runs)
        .Paper(paper);
  };
  measure("raw stream", loop::Generator::kNone, 100);
  measure("reference generator", loop::Generator::kJoint, 0);
  findings.Add("from one sample to the next, off a cycle: median", "us", SpreadOf(median_us));
  findings.Add("the same, p99", "us", SpreadOf(p99_us));
  return findings;
}

Findings RunJitter(const Config& config) {
  const StreamInputs inputs = LoadStreamInputs(config);
  const JointLimits& limits = inputs.robot.limits;
  Findings findings{.values = {{"runs", fmt::format("{}", config.seeds)},
                               {"ppm", fmt::format("{}", kFreeRunningPpm)}}};
  findings
      .Add("one sample displaced by 4 us at 1 rad/s: jerk", "rad/s^3",
           JerkOfOneSample(1, kPaperJitter))
      .Paper(1.2e4);
  // The reconstructed jerk beside its own expansion holds by arithmetic: no demand.
  const auto measure = [&](control::CommandInterface interface, const std::string& name) {
    JitterJerk jerk = JerkOfJitter(inputs.canonical, limits, interface, kPaperJitter, config.seed);
    findings.Add(name + ": RMS of the jerk of jitter, reconstructed / formula", "", jerk.ratio)
        .Paper(1);
    findings.Add(name + ": RMS of reconstructed - formula, of the formula's", "%",
                 jerk.residual * 100);
    return jerk;
  };
  const JitterJerk position =
      measure(control::CommandInterface::kJointPosition, "position interface");
  const JitterJerk velocity =
      measure(control::CommandInterface::kJointVelocity, "velocity interface");
  CompareCanonical(config, inputs, findings);
  CompareRemedies(config, inputs, findings);
  const AbortMap map =
      MapAborts(PartOf(config, 0.3, 0.8), inputs.robot, kJittersUs, kSpeeds, config.seeds);
  findings.figures = {SamplesFigure(inputs.robot, config.seed),
                      FigureOf("jerk", {{"t [s]", position.t},
                                        {"position measured [rad/s^3]", position.measured[0]},
                                        {"position formula [rad/s^3]", position.formula[0]},
                                        {"velocity measured [rad/s^3]", velocity.measured[0]},
                                        {"velocity formula [rad/s^3]", velocity.formula[0]}}),
                      AbortMapFigure(map, config.seeds, limits)};
  AddPaces(MeasurePaces(PartOf(config, 0.8, 1), inputs,
                        {0.1, 0.15, 0.21, 0.24, 0.27, 0.35, 0.45, 0.55, 0.68}, config.seeds),
           limits, findings);
  return findings;
}

}  // namespace twin::experiment

#include <cmath>

#include <fmt/format.h>

#include "experiment/stream.h"
#include "experiment/studies.h"

namespace twin::experiment {
namespace {

/// A method to form dq_ext.
struct Method {
  VelocityFrom from;
  const char* name;
};
constexpr std::array<Method, 3> kMethods{
    Method{VelocityFrom::kSourceTime, "over the source's elapsed time"},
    Method{VelocityFrom::kNominalTime, "over the nominal T"},
    Method{VelocityFrom::kConsumption, "where consumed"}};
constexpr std::array<double, 6> kDriftsPpm{0, 10, 20, 50, 100, 200};
constexpr std::size_t kUsualDrift = 3;

Stream StreamWith(VelocityFrom velocity) {
  return {.tick = {.generator = loop::Generator::kJoint, .limiter = {}, .cost = {}},
          .velocity = velocity};
}

/// The runs of each drift, method by method.
using FeedForwardTable = Grid<StreamRuns>;

FeedForwardTable MeasureFeedForward(const Config& config, const StreamInputs& inputs,
                                    double jitter_s) {
  return MapGrid(
      config, kMethods.size(), kDriftsPpm.size(), [&](std::size_t method, std::size_t drift) {
        return RunFeedForward(config, inputs.canonical, inputs.robot.limits, kMethods[method].from,
                              jitter_s, kDriftsPpm[drift], std::min(config.seeds, 5));
      });
}

Figure DriftFigure(const FeedForwardTable& jittered, const FeedForwardTable& exact) {
  Figure figure{.id = "drift",
                .columns =
                    "jitter [s],way (0: source's time; 1: nominal T; 2: consumption),"
                    "drift [ppm],largest jerk / limit,RMS jerk / limit,share of runs aborted"};
  for (const FeedForwardTable* table : {&jittered, &exact}) {
    for (std::size_t method = 0; method < kMethods.size(); ++method) {
      for (std::size_t i = 0; i < kDriftsPpm.size(); ++i) {
        const StreamRuns& runs = (*table)[method][i];
        figure.rows.push_back(Row(table == &jittered ? kPaperJitter : 0, method, kDriftsPpm[i],
                                  runs.jerk, runs.rms_jerk, runs.aborted));
      }
    }
  }
  return figure;
}

/// Velocity and jerk of joint 1 about the crossing of two loops without jitter.
Figure CrossingFigure(const StreamInputs& inputs) {
  constexpr double kCrossing = 1.5;  // s
  Figure figure{.id = "crossing",
                .columns =
                    "way (0: source's time; 1: nominal T; 2: consumption),t [s],"
                    "dq_d [rad/s],jerk / limit"};
  for (std::size_t method = 0; method < kMethods.size(); ++method) {
    Stream stream = StreamWith(kMethods[method].from);
    stream.clock_ppm = kFreeRunningPpm;
    stream.phase = FromSeconds(kCrossing * kFreeRunningPpm * 1e-6);
    const auto keep = [&](std::uint64_t k, const onboard::JointReference& next) {
      const double t = static_cast<double>(k) * kCycleSeconds;
      if (std::abs(t - kCrossing) > 0.03) return;
      figure.rows.push_back(
          Row(method, t, next.dq_d[0], next.dddq_d[0] / inputs.robot.limits.dddq_max[0]));
    };
    static_cast<void>(RunStream(inputs.canonical, inputs.robot.limits, stream, false, keep));
  }
  return figure;
}

/// RMS jerk of jitter with the nominal period, over that of a raw stream.
double NominalOverRaw(const StreamInputs& inputs, std::uint64_t seed) {
  const auto rms_jerk = [&](loop::Generator generator) {
    Stream stream = StreamWith(VelocityFrom::kNominalTime);
    stream.tick.generator = generator;
    stream.jitter_s = kPaperJitter;
    stream.seed = seed;
    return Largest(RunStream(inputs.canonical, inputs.robot.limits, stream, false).rms_jerk);
  };
  return rms_jerk(loop::Generator::kJoint) / rms_jerk(loop::Generator::kNone);
}

void CompareFeedForward(const FeedForwardTable& jittered, const FeedForwardTable& exact,
                        Findings& findings) {
  for (std::size_t method = 0; method < kMethods.size(); ++method) {
    const auto& [from, name] = kMethods[method];
    const bool is_source = from == VelocityFrom::kSourceTime;
    for (const std::size_t drift : {std::size_t{0}, kUsualDrift}) {
      const StreamRuns& runs = jittered[method][drift];
      const std::string where = fmt::format("{}, 4 us, {:.0f} ppm: ", name, kDriftsPpm[drift]);
      findings.Add(where + "largest jerk / limit", "", runs.jerk)
          .Demand(is_source ? "at most 1" : "", runs.jerk <= 1);
      findings.Add(where + "runs aborted", "%", runs.aborted * 100)
          .Demand(is_source ? "none" : "all of them", runs.aborted == (is_source ? 0 : 1));
    }
    const double aborted = exact[method][kUsualDrift].aborted;
    const bool is_consumption = from == VelocityFrom::kConsumption;
    findings
        .Add(fmt::format("{}, no jitter, {:.0f} ppm: runs aborted", name, kDriftsPpm[kUsualDrift]),
             "%", aborted * 100)
        .Demand(is_consumption ? "all of them" : "none", aborted == (is_consumption ? 1 : 0));
  }
}

}  // namespace

StreamRuns RunFeedForward(const Config& config, const reference::Trajectory& plan,
                          const JointLimits& limits, VelocityFrom velocity, double jitter_s,
                          double ppm, int runs) {
  std::vector<StreamResult> results;
  for (int run = 0; run < runs; ++run) {
    Stream stream = StreamWith(velocity);
    stream.jitter_s = jitter_s;
    stream.clock_ppm = ppm;
    if (ppm > 0) stream.phase = PhaseOfOvertaking(plan, ppm, ChoiceOfRun(config, run));
    stream.seed = SeedOfRun(config, run);
    results.push_back(RunStream(plan, limits, stream, false));
  }
  return SummaryOf(results);
}

Findings RunFeedForwardStudy(const Config& config) {
  const StreamInputs inputs = LoadStreamInputs(config);
  const FeedForwardTable jittered =
      MeasureFeedForward(PartOf(config, 0, 0.5), inputs, kPaperJitter);
  const FeedForwardTable exact = MeasureFeedForward(PartOf(config, 0.5, 0.9), inputs, 0);
  Findings findings;
  CompareFeedForward(jittered, exact, findings);
  const double nominal = NominalOverRaw(inputs, config.seed);
  findings.Add("over the nominal T, 4 us: RMS jerk / that of the raw stream", "", nominal)
      .Demand("within 5 % of 1", std::abs(nominal - 1) <= 0.05);
  using enum reference::FeedForwardTime;
  for (const auto& [time, method] : {std::pair(kSource, kMethods[0]), {kNominal, kMethods[1]}}) {
    const double aborted = FailedShare(PartOf(config, 0.9, 1), std::min(config.seeds, 4),
                                       [time = time](scenario::Scenario& scenario) {
                                         scenario.tick.limiter = false;
                                         scenario.controller.feed_forward = time;
                                       });
    findings.Add(fmt::format("{}, whole stack with the calibrated delays, limiter off: runs "
                             "aborted",
                             method.name),
                 "%", 100 * aborted);
  }
  findings.figures = {DriftFigure(jittered, exact), CrossingFigure(inputs)};
  return findings;
}

}  // namespace twin::experiment

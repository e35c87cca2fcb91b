#include "experiment/feed_forward.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiment/jitter_parts.h"
#include "experiment/runs.h"

namespace twin::experiment {
namespace {

constexpr double kJitter = 4e-6;  // s, the paper's

/// A way to form dq_ext.
struct Way {
  VelocityFrom from;
  const char* name;
};
constexpr std::array<Way, 3> kWays{Way{VelocityFrom::kSourceTime, "over the source's elapsed time"},
                                   Way{VelocityFrom::kNominalTime, "over the nominal T"},
                                   Way{VelocityFrom::kConsumption, "where consumed"}};
constexpr std::array<double, 6> kPpm{0, 10, 20, 50, 100, 200};
constexpr std::size_t kUsualPpm = 3;

Stream StreamWith(VelocityFrom velocity) {
  return {.tick = {.generator = loop::Generator::kJoint, .limiter = {}, .cost = {}},
          .velocity = velocity};
}

using Table = std::array<std::array<FeedForwardRuns, kPpm.size()>, kWays.size()>;

Table Fill(const Setting& setting, const StreamSetting& streams, double jitter_s, double from,
           double to) {
  Table table{};
  const int runs = std::min(setting.seeds, 5);
  InParallel(
      setting, static_cast<int>(kWays.size() * kPpm.size()),
      [&](int index) {
        const std::size_t way = static_cast<std::size_t>(index) / kPpm.size();
        const std::size_t drift = static_cast<std::size_t>(index) % kPpm.size();
        table[way][drift] = RunFeedForward(setting, streams.canonical, streams.robot.limits,
                                           kWays[way].from, jitter_s, kPpm[drift], runs);
      },
      from, to);
  return table;
}

Figure DriftFigure(const Table& jittered, const Table& exact) {
  Figure figure{.id = "drift",
                .columns =
                    "jitter [s],way (0: source's time; 1: nominal T; 2: consumption),"
                    "drift [ppm],largest jerk / limit,RMS jerk / limit,share of runs aborted"};
  for (const Table* table : {&jittered, &exact}) {
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      for (std::size_t i = 0; i < kPpm.size(); ++i) {
        const FeedForwardRuns& runs = (*table)[way][i];
        figure.rows.push_back({table == &jittered ? kJitter : 0, static_cast<double>(way), kPpm[i],
                               runs.jerk, runs.rms_jerk, runs.aborted});
      }
    }
  }
  return figure;
}

/// Velocity and jerk of joint 1 about the crossing of two loops without jitter.
Figure CrossingFigure(const StreamSetting& streams) {
  constexpr double kCrossing = 1.5;  // s
  constexpr double kFastPpm = 50;
  Figure figure{.id = "crossing",
                .columns =
                    "way (0: source's time; 1: nominal T; 2: consumption),t [s],"
                    "dq_d [rad/s],jerk / limit"};
  for (std::size_t way = 0; way < kWays.size(); ++way) {
    Stream stream = StreamWith(kWays[way].from);
    stream.clock_ppm = kFastPpm;
    stream.phase = FromSeconds(kCrossing * kFastPpm * 1e-6);
    const auto keep = [&](const StreamCycle& cycle) {
      const double t = static_cast<double>(cycle.cycle) * kCycleSeconds;
      if (std::abs(t - kCrossing) > 0.03) return;
      figure.rows.push_back({static_cast<double>(way), t, cycle.next.dq_d[0],
                             cycle.next.dddq_d[0] / streams.robot.limits.dddq_max[0]});
    };
    static_cast<void>(RunStream(streams.canonical, streams.robot.limits, stream, false, keep));
  }
  return figure;
}

/// RMS jerk that jitter leaves with the nominal period, against what it makes of a raw stream.
double NominalAgainstRaw(const StreamSetting& streams, std::uint64_t seed) {
  double rms[2];
  for (const bool raw : {false, true}) {
    Stream stream = StreamWith(VelocityFrom::kNominalTime);
    if (raw) stream.tick.generator = loop::Generator::kNone;
    stream.jitter_s = kJitter;
    stream.seed = seed;
    rms[raw ? 1 : 0] =
        Largest(RunStream(streams.canonical, streams.robot.limits, stream, false).rms_jerk);
  }
  return rms[0] / rms[1];
}

/// Share of runs that abort through the whole stack, in the calibrated asynchronous loop.
double AbortsThroughStack(const Setting& setting, reference::FeedForwardTime time) {
  const int runs = std::min(setting.seeds, 4);
  const int aborted = CountFailures(
      setting, runs,
      [&](scenario::Scenario& scenario) {
        scenario.tick.limiter = false;
        scenario.controller.feed_forward = time;
      },
      0.9, 1);
  return static_cast<double>(aborted) / runs;
}

void Compare(const Table& jittered, const Table& exact, double nominal, Findings& findings) {
  const auto add = [&](std::string quantity, std::string unit, double ours, std::string demand,
                       bool met) {
    const Verdict verdict = demand.empty() ? Verdict::kReported : Judge(met);
    findings.comparisons.push_back({.quantity = std::move(quantity),
                                    .unit = std::move(unit),
                                    .ours = ours,
                                    .demand = std::move(demand),
                                    .verdict = verdict});
  };
  for (std::size_t way = 0; way < kWays.size(); ++way) {
    const bool is_source = kWays[way].from == VelocityFrom::kSourceTime;
    for (const std::size_t drift : {std::size_t{0}, kUsualPpm}) {
      const FeedForwardRuns& runs = jittered[way][drift];
      const std::string where = fmt::format("{}, 4 us, {:.0f} ppm: ", kWays[way].name, kPpm[drift]);
      add(where + "largest jerk / limit", "", runs.jerk, is_source ? "at most 1" : "",
          runs.jerk <= 1);
      add(where + "runs aborted", "%", runs.aborted * 100, is_source ? "none" : "all of them",
          runs.aborted == (is_source ? 0 : 1));
    }
    const FeedForwardRuns& crossing = exact[way][kUsualPpm];
    const bool is_consumption = kWays[way].from == VelocityFrom::kConsumption;
    add(fmt::format("{}, no jitter, {:.0f} ppm: runs aborted", kWays[way].name, kPpm[kUsualPpm]),
        "%", crossing.aborted * 100, is_consumption ? "all of them" : "none",
        crossing.aborted == (is_consumption ? 1 : 0));
  }
  add("over the nominal T, 4 us: RMS jerk / that of the raw stream", "", nominal, "within 5 % of 1",
      std::abs(nominal - 1) <= 0.05);
}

}  // namespace

FeedForwardRuns RunFeedForward(const Setting& setting, const reference::Trajectory& plan,
                               const JointLimits& limits, VelocityFrom velocity, double jitter_s,
                               double ppm, int runs) {
  FeedForwardRuns all;
  for (int run = 0; run < runs; ++run) {
    Stream stream = StreamWith(velocity);
    stream.jitter_s = jitter_s;
    stream.clock_ppm = ppm;
    if (ppm > 0) stream.phase = CrossingPhase(plan, ppm, ChoiceOfRun(setting, run));
    stream.seed = SeedOfRun(setting, run);
    const StreamResult result = RunStream(plan, limits, stream, false);
    all.aborted += result.aborted ? 1 : 0;
    all.jerk = std::max(all.jerk, Largest(result.jerk));
    all.rms_jerk += Largest(result.rms_jerk) / runs;
  }
  all.aborted /= runs;
  return all;
}

Findings RunFeedForwardStudy(const Setting& setting) {
  const StreamSetting streams = LoadStreamSetting(setting);
  const Table jittered = Fill(setting, streams, kJitter, 0, 0.5);
  const Table exact = Fill(setting, streams, 0, 0.5, 0.9);
  Findings findings;
  Compare(jittered, exact, NominalAgainstRaw(streams, setting.seed), findings);
  for (const auto time :
       {reference::FeedForwardTime::kSource, reference::FeedForwardTime::kNominal}) {
    findings.comparisons.push_back(
        {.quantity = fmt::format(
             "{}, whole stack with the calibrated delays, limiter off: runs "
             "aborted",
             time == reference::FeedForwardTime::kSource ? kWays[0].name : kWays[1].name),
         .unit = "%",
         .ours = 100 * AbortsThroughStack(setting, time)});
  }
  findings.figures = {DriftFigure(jittered, exact), CrossingFigure(streams)};
  return findings;
}

}  // namespace twin::experiment

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "experiment/runs.h"
#include "experiment/stream_studies.h"

namespace twin::experiment {
namespace {

constexpr double kFreeRunningPpm = 50;
constexpr double kSpeed = 1;  // of the jitter figure, rad/s

/// @returns INT's references behind a stream, cycle by cycle.
std::vector<onboard::JointReference> ReferencesOf(const reference::Trajectory& plan,
                                                  const JointLimits& limits, const Stream& stream) {
  std::vector<onboard::JointReference> references;
  static_cast<void>(RunStream(plan, limits, stream, false,
                              [&](const StreamCycle& cycle) { references.push_back(cycle.next); }));
  return references;
}

/// Backward difference of the sampling errors at deposit i, s.
double Difference(const Stream& stream, std::size_t i, int order) {
  if (order == 0) return ToSeconds(SamplingError(stream, i));
  return Difference(stream, i, order - 1) - Difference(stream, i - 1, order - 1);
}

double SumOfSquares(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
}

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
                   const std::vector<double>& jitter_us, const std::vector<double>& speed,
                   int runs) {
  constexpr double kPeakSpeed = 1.875;  // of 1 rad in 1 s
  AbortMap map{.jitter_us = jitter_us, .speed = speed, .runs = runs};
  for (auto& probability : map.probability) probability.resize(jitter_us.size() * speed.size());
  const auto job = [&](int place) {
    const auto index = static_cast<std::size_t>(place);
    const reference::Trajectory plan =
        SecondOfMotion({speed[index / jitter_us.size()] / kPeakSpeed}, robot.limits);
    for (std::size_t remedy = 0; remedy < kRemedyNames.size(); ++remedy) {
      Stream stream = StreamBehind(static_cast<Remedy>(remedy), robot);
      stream.jitter_s = jitter_us[index % jitter_us.size()] * 1e-6;
      stream.clock_ppm = kFreeRunningPpm;
      const int needed = stream.on_robot_time ? 1 : runs;  // nothing in it is random
      int aborts = 0;
      for (int run = 0; run < needed; ++run) {
        stream.seed = SeedOfRun(config, place * runs + run);
        stream.phase = PhaseOfRun(config, place * runs + run);
        if (RunStream(plan, robot.limits, stream, true).aborted) ++aborts;
      }
      map.probability[remedy][index] = static_cast<double>(aborts) / needed;
    }
  };
  InParallel(config, static_cast<int>(jitter_us.size() * speed.size()), job, 0.3, 0.8);
  return map;
}

std::vector<PaceResult> MeasurePaces(const Config& config, const StreamInputs& inputs,
                                     const std::vector<double>& shares, int runs) {
  const JointLimits& limits = inputs.robot.limits;
  std::vector<reference::Trajectory> plans;
  plans.reserve(shares.size());
  for (const double share : shares) plans.push_back(BriskAt(config, limits, share));
  const auto measure = [&](int number) {
    const reference::Trajectory& plan = plans[number / runs];
    Stream stream = StreamBehind(Remedy::kGenerator, inputs.robot);
    stream.jitter_s = kPaperJitter;
    stream.clock_ppm = kFreeRunningPpm;
    stream.seed = SeedOfRun(config, number);
    stream.phase = PhaseOfOvertaking(plan, kFreeRunningPpm, ChoiceOfRun(config, number));
    return RunStream(plan, limits, stream, false);
  };
  const std::vector<StreamResult> results =
      MapInParallel(config, shares.size() * runs, measure, 0.8, 1);
  std::vector<PaceResult> paces;
  for (const reference::Trajectory& plan : plans) {
    paces.push_back({.acceleration = Largest(plan.peaks().acceleration)});
  }
  for (std::size_t i = 0; i < results.size(); ++i) {
    PaceResult& pace = paces[i / runs];
    pace.jerk = std::max(pace.jerk, Largest(results[i].jerk));
    pace.aborted += results[i].aborted ? 1.0 / runs : 0;
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

Figure SamplesFigure(const scenario::RobotData& robot, std::uint64_t seed) {
  const reference::Trajectory plan = SecondOfMotion({kSpeed / 1.875}, robot.limits);
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
  Figure figure{.id = "jerk",
                .columns =
                    "t [s],position measured [rad/s^3],position formula [rad/s^3],"
                    "velocity measured [rad/s^3],velocity formula [rad/s^3]"};
  for (std::size_t i = 0; i < std::min(position.t.size(), velocity.t.size()); ++i) {
    figure.rows.push_back({position.t[i], position.measured[0][i], position.formula[0][i],
                           velocity.measured[0][i], velocity.formula[0][i]});
  }
  return figure;
}

Figure AbortMapFigure(const AbortMap& map, const JointLimits& limits) {
  Figure figure{.id = "map",
                .columns = "jitter [us],peak speed [rad/s]",
                .values = {{"runs", map.runs}, {"jerk_limit", limits.dddq_max[0]}},
                .names = {kRemedyNames.begin(), kRemedyNames.end()}};
  for (const std::string_view name : kRemedyNames) figure.columns.append(",").append(name);
  for (std::size_t i = 0; i < map.probability[0].size(); ++i) {
    std::vector<double>& row = figure.rows.emplace_back(
        std::vector{map.jitter_us[i % map.jitter_us.size()], map.speed[i / map.jitter_us.size()]});
    for (const auto& probability : map.probability) row.push_back(probability[i]);
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

}  // namespace twin::experiment

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "experiment/jitter_parts.h"

namespace twin::experiment {
namespace {

constexpr double kT = kCycleSeconds;
constexpr double kSpeed = 1;      // of the jitter figure, rad/s
constexpr double kJitter = 4e-6;  // s, the paper's

/// Joint 1 of a raw stream, as INT reconstructs it.
struct RawStream {
  std::vector<double> q_d;
  std::vector<double> dq_d;
  std::vector<double> ddq_d;
};

RawStream Reconstruct(const reference::Trajectory& plan, const JointLimits& limits,
                      const Stream& stream) {
  RawStream raw;
  static_cast<void>(RunStream(plan, limits, stream, false, [&](const StreamCycle& cycle) {
    raw.q_d.push_back(cycle.next.q_d[0]);
    raw.dq_d.push_back(cycle.next.dq_d[0]);
    raw.ddq_d.push_back(cycle.next.ddq_d[0]);
  }));
  return raw;
}

/// A close-up of samples displaced, where they were planned and where they are filed. Its jitter is
/// 40 times as large, or it could not be seen.
report::Table DisplacedSamples(const reference::Trajectory& plan, const JointLimits& limits,
                               Stream stream) {
  constexpr std::size_t kBegin = 494;
  constexpr std::size_t kEnd = 507;
  stream.jitter_s = 160e-6;
  const RawStream raw = Reconstruct(plan, limits, stream);
  const double q0 = plan.Sample(FromSeconds(0.5)).q[0];
  report::Table table{.columns = "filed at [ms],sampled at [ms],intended [mrad],sampled [mrad]"};
  for (std::size_t i = kBegin; i < kEnd; ++i) {
    const double t = static_cast<double>(i) * kT;
    table.rows.push_back({t * 1e3, (t + ToSeconds(SamplingError(stream, i))) * 1e3,
                          (plan.Sample(FromSeconds(t)).q[0] - q0) * 1e3, (raw.q_d[i] - q0) * 1e3});
  }
  return table;
}

/// One edge of the cone: what follows when the acceleration changes by `jerk` as long as its limit
/// admits. @returns the increment, rad, of the n-th cycle after `from`.
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

/// One sample 4 us late in a motion at constant speed: the increment after it leaves the cone of
/// those that are admissible.
report::Table Cone(const JointLimits& limits) {
  constexpr int kLate = 5;
  constexpr double kIntended = kSpeed * kT;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  onboard::JointReference reference = onboard::JointReference::Rest({});
  onboard::JointReference late;
  reference.dq_d[0] = kSpeed;
  report::Table table{.columns = "cycle,increment [urad],least [urad],most [urad],refused [urad]"};
  for (int k = 1; k <= kLate + 2; ++k) {
    const double t = k * kT + (k == kLate ? kJitter : 0);
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

Figure SamplesFigure(const scenario::RobotData& robot, std::uint64_t seed) {
  const reference::Trajectory plan = SecondOfMotion({kSpeed / 1.875}, robot.limits);
  Stream stream = StreamBehind(Remedy::kNone, robot);
  stream.seed = seed;
  stream.jitter_s = kJitter;
  const RawStream raw = Reconstruct(plan, robot.limits, stream);
  Figure figure{.id = "samples",
                .columns =
                    "t [s],sampling error [s],intended q [rad],reconstructed q [rad],"
                    "reconstructed dq [rad/s],reconstructed ddq [rad/s^2]",
                .tables = {{"displaced", DisplacedSamples(plan, robot.limits, stream)},
                           {"cone", Cone(robot.limits)}}};
  for (std::size_t i = 0; i < raw.q_d.size(); ++i) {
    const double t = static_cast<double>(i) * kT;
    figure.rows.push_back({t, ToSeconds(SamplingError(stream, i)), plan.Sample(FromSeconds(t)).q[0],
                           raw.q_d[i], raw.dq_d[i], raw.ddq_d[i]});
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

Figure EndFigure(const std::vector<Pace>& paces, const JointLimits& limits) {
  Figure figure{.id = "end",
                .columns = "largest ddq / its limit,largest jerk / its limit,share of runs aborted",
                .values = {{"limit_ratio", limits.ddq_max[0] / limits.dddq_max[0]}}};
  for (const Pace& pace : paces) {
    figure.rows.push_back({pace.acceleration, pace.jerk, pace.aborted});
  }
  return figure;
}

}  // namespace twin::experiment

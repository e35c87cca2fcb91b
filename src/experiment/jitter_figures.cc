#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "experiment/jitter_parts.h"
#include "twin/report/chart.h"

namespace twin::experiment {
namespace {

using report::Chart;
using report::ChartCurve;
using report::ChartPanel;
using Style = report::ChartCurve::Style;

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

/// Samples displaced, where they were planned and where they are filed; in a close-up with 40 times
/// the jitter, or it could not be seen.
ChartPanel DisplacedPanel(const reference::Trajectory& plan, const JointLimits& limits,
                          Stream stream) {
  constexpr std::size_t kBegin = 494;
  constexpr std::size_t kEnd = 507;
  stream.jitter_s = 160e-6;
  const RawStream raw = Reconstruct(plan, limits, stream);
  const double q0 = plan.Sample(FromSeconds(0.5)).q[0];
  ChartCurve intended{.name = "intended q*(t)", .colour = report::colour::kReference};
  ChartCurve sampled{.name = "sampled at kT + dt(k)",
                     .colour = report::colour::kAsynchronous,
                     .style = Style::kPoints};
  ChartCurve filed{.name = "filed at kT: what INT reconstructs",
                   .colour = report::colour::kSynchronous};
  ChartCurve filed_points{.colour = report::colour::kSynchronous, .style = Style::kPoints};
  for (std::size_t i = kBegin; i < kEnd; ++i) {
    const double t = static_cast<double>(i) * kT;
    intended.x.push_back(t * 1e3);
    intended.y.push_back((plan.Sample(FromSeconds(t)).q[0] - q0) * 1e3);
    sampled.x.push_back((t + ToSeconds(SamplingError(stream, i))) * 1e3);
    sampled.y.push_back((raw.q_d[i] - q0) * 1e3);
    filed.x.push_back(t * 1e3);
    filed.y.push_back((raw.q_d[i] - q0) * 1e3);
  }
  filed_points.x = filed.x;
  filed_points.y = filed.y;
  return {.title = "Samples displaced in time, at 1 rad/s (40 times the jitter, to be seen)",
          .x_label = "t [ms]",
          .y_label = "q - q*(500 ms) [mrad]",
          .curves = {intended, filed, filed_points, sampled}};
}

ChartPanel DeviationPanel(const reference::Trajectory& plan, const RawStream& raw) {
  constexpr std::size_t kBegin = 470;
  constexpr std::size_t kEnd = 531;
  ChartCurve intended{
      .name = "intended", .colour = report::colour::kReference, .style = Style::kLine};
  ChartCurve found{.name = "reconstructed", .colour = report::colour::kSynchronous};
  for (std::size_t i = kBegin; i < kEnd; ++i) {
    const double t = static_cast<double>(i) * kT;
    intended.x.push_back(t * 1e3);
    intended.y.push_back(0);
    found.x.push_back(t * 1e3);
    found.y.push_back((raw.q_d[i] - plan.Sample(FromSeconds(t)).q[0]) * 1e6);
  }
  return {.title = "The reconstructed reference against the intended one, jitter 4 us",
          .x_label = "t [ms]",
          .y_label = "q_d - q* [urad]",
          .curves = {intended, found}};
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
/// those that were admissible.
ChartPanel ConePanel(const JointLimits& limits) {
  constexpr int kLate = 5;
  constexpr double kIntended = kSpeed * kT;
  onboard::JointReference reference = onboard::JointReference::Rest({});
  reference.dq_d[0] = kSpeed;
  ChartCurve upper{.name = "admissible after the displaced sample",
                   .colour = report::colour::kLimit};
  ChartCurve lower{.colour = report::colour::kLimit};
  ChartCurve line{.name = "increments", .colour = report::colour::kAsynchronous};
  for (int k = 1; k <= kLate + 2; ++k) {
    const double t = k * kT + (k == kLate ? kJitter : 0);
    reference = reference.AfterPosition({kSpeed * t});
    line.x.push_back(k);
    line.y.push_back((reference.dq_d[0] * kT - kIntended) * 1e6);
    for (int n = 0; k == kLate && n <= 2; ++n) {
      upper.x.push_back(k + n);
      upper.y.push_back((ConeEdge(reference, limits, limits.dddq_max[0], n) - kIntended) * 1e6);
      lower.y.push_back((ConeEdge(reference, limits, -limits.dddq_max[0], n) - kIntended) * 1e6);
    }
  }
  lower.x = upper.x;
  ChartCurve points{
      .colour = report::colour::kAsynchronous, .style = Style::kPoints, .x = line.x, .y = line.y};
  ChartCurve refused{.name = "refused",
                     .colour = report::colour::kSynchronous,
                     .style = Style::kPoints,
                     .x = {line.x[kLate]},
                     .y = {line.y[kLate]}};
  return {.title = "Inset: one sample 4 us late at 1 rad/s; the next increment leaves the cone",
          .x_label = "cycle",
          .y_label = "increment - intended [urad]",
          .curves = {upper, lower, line, points, refused}};
}

ChartPanel JerkPanel(const JitterJerk& jerk, const char* title) {
  constexpr std::size_t kJoint = 0;
  constexpr std::size_t kBegin = 1000;
  constexpr std::size_t kCount = 60;
  ChartCurve formula{.name = "formula", .colour = report::colour::kReference};
  ChartCurve measured{.name = "reconstructed by INT",
                      .colour = report::colour::kSynchronous,
                      .style = Style::kPoints};
  for (std::size_t i = kBegin; i < std::min(kBegin + kCount, jerk.t.size()); ++i) {
    formula.x.push_back(jerk.t[i]);
    formula.y.push_back(jerk.formula[kJoint][i]);
    measured.y.push_back(jerk.measured[kJoint][i]);
  }
  measured.x = formula.x;
  return {.title = title,
          .x_label = "t [s]",
          .y_label = "jerk of joint 1 [rad/s^3]",
          .curves = {formula, measured}};
}

}  // namespace

Figure DrawJitter(const scenario::RobotData& robot, std::uint64_t seed) {
  const reference::Trajectory plan = SecondOfMotion({kSpeed / 1.875}, robot.limits);
  Stream stream = StreamBehind(Remedy::kNone, robot);
  stream.seed = seed;
  stream.jitter_s = kJitter;
  const RawStream raw = Reconstruct(plan, robot.limits, stream);
  Figure figure{
      .id = "samples",
      .title = "Sampling jitter",
      .what =
          "Samples taken a few microseconds early or late are filed as though they were on time; "
          "the "
          "reference wavers by microradians, and soon one increment is outside of what the "
          "jerk limit admits.",
      .svg = report::DrawChart({.title = "Sampling jitter",
                                .panels = {DisplacedPanel(plan, robot.limits, stream),
                                           DeviationPanel(plan, raw), ConePanel(robot.limits)}}),
      .columns =
          "t [s],sampling error [s],intended q [rad],reconstructed q [rad],"
          "reconstructed dq [rad/s],reconstructed ddq [rad/s^2]"};
  for (std::size_t i = 0; i < raw.q_d.size(); ++i) {
    const double t = static_cast<double>(i) * kT;
    figure.rows.push_back({t, ToSeconds(SamplingError(stream, i)), plan.Sample(FromSeconds(t)).q[0],
                           raw.q_d[i], raw.dq_d[i], raw.ddq_d[i]});
  }
  return figure;
}

Figure DrawJitterJerk(const JitterJerk& position, const JitterJerk& velocity) {
  Figure figure{
      .id = "jerk",
      .title = "Jerk that jitter makes",
      .what = "The jerk INT reconstructs lies on the paper's formula, on both interfaces.",
      .svg = report::DrawChart({.title = "Jerk that jitter of 4 us makes, canonical trajectory",
                                .panels = {JerkPanel(position, "Position: dq* D3 dt / T^3"),
                                           JerkPanel(velocity, "Velocity: ddq* D2 dt / T^2")}}),
      .columns =
          "t [s],position measured [rad/s^3],position formula [rad/s^3],"
          "velocity measured [rad/s^3],velocity formula [rad/s^3]"};
  for (std::size_t i = 0; i < std::min(position.t.size(), velocity.t.size()); ++i) {
    figure.rows.push_back({position.t[i], position.measured[0][i], position.formula[0][i],
                           velocity.measured[0][i], velocity.formula[0][i]});
  }
  return figure;
}

Figure DrawAbortMap(const AbortMap& map, const JointLimits& limits) {
  Chart chart{
      .title = fmt::format("Probability of an abort in 1 s of joint 1 ({} runs a place)", map.runs),
      .columns = 2,
      .width = 1000,
      .panel_height = 280};
  // The third difference of white samples has sqrt(20) times their deviation.
  ChartCurve line{
      .name = "RMS jerk = limit", .colour = report::colour::kAsynchronous, .style = Style::kDashed};
  for (const double speed : map.speed) {
    line.x.push_back(limits.dddq_max[0] * kT * kT * kT / std::sqrt(20.0) / speed * 1e6);
    line.y.push_back(speed);
  }
  Figure figure{
      .id = "map",
      .title = "Aborts against jitter and speed",
      .what =
          "A raw stream aborts the earlier the faster it moves, as the line has it; what remains "
          "with the reference generator, deposits consumed twice and the jitter's own "
          "error, comes with tenfold jitter.",
      .columns = "jitter [us],peak speed [rad/s]"};
  for (std::size_t way = 0; way < kRemedyNames.size(); ++way) {
    const std::string name(kRemedyNames[way]);
    figure.columns += "," + name;
    chart.panels.push_back({.title = name,
                            .x_label = "jitter, standard deviation [us]",
                            .y_label = "peak speed [rad/s]",
                            .log_x = true,
                            .map = report::HeatMap{.x = map.jitter_us,
                                                   .y = map.speed,
                                                   .z = map.probability[way],
                                                   .z_label = "aborted",
                                                   .z_range = {{0, 1}}}});
  }
  chart.panels[0].curves.push_back(line);
  figure.svg = report::DrawChart(chart);
  for (std::size_t i = 0; i < map.probability[0].size(); ++i) {
    std::vector<double> row{map.jitter_us[i % map.jitter_us.size()],
                            map.speed[i / map.jitter_us.size()]};
    for (const auto& probability : map.probability) row.push_back(probability[i]);
    figure.rows.push_back(row);
  }
  return figure;
}

Figure DrawEnd(const std::vector<Pace>& paces, const JointLimits& limits) {
  ChartCurve jerk{.name = "reference generator", .colour = report::colour::kAsynchronous};
  ChartCurve formula{
      .name = "2 ddq / T", .colour = report::colour::kReference, .style = Style::kDashed};
  ChartCurve limit{.name = "limit", .colour = report::colour::kLimit, .x = {}, .y = {}};
  ChartCurve aborted{.name = "runs aborted", .colour = report::colour::kSynchronous};
  Figure figure{
      .id = "end",
      .title = "Where the reference generator's promise ends",
      .what =
          "A deposit consumed twice beside a skipped one makes a jerk of 2 ddq / T, which is "
          "beyond its limit from a quarter of the acceleration limit on.",
      .columns = "largest ddq / its limit,largest jerk / its limit,share of runs aborted"};
  for (const Pace& pace : paces) {
    jerk.x.push_back(pace.acceleration);
    jerk.y.push_back(pace.jerk);
    aborted.y.push_back(pace.aborted * 100);
    formula.y.push_back(2 * pace.acceleration * limits.ddq_max[0] / kT / limits.dddq_max[0]);
    limit.y.push_back(1);
    figure.rows.push_back({pace.acceleration, pace.jerk, pace.aborted});
  }
  formula.x = limit.x = aborted.x = jerk.x;
  figure.svg = report::DrawChart(
      {.title = "Brisk trajectory at several paces: jitter 4 us, clocks 50 ppm apart",
       .panels = {{.title = "Largest jerk of all runs",
                   .x_label = "largest acceleration / its limit",
                   .y_label = "jerk / its limit",
                   .curves = {formula, limit, jerk}},
                  {.title = "Runs that end in an abort",
                   .x_label = "largest acceleration / its limit",
                   .y_label = "aborted [%]",
                   .curves = {aborted}}}});
  return figure;
}

}  // namespace twin::experiment

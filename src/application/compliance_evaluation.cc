#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "application/compliance.h"

namespace twin::application::compliance {
namespace {

/// Upper bound of the stiff case's deflection, as a share of the compliant one's.
constexpr double kStiffShare = 0.2;
/// Largest relative deviation of the steady deflection from F / K.
constexpr double kSteadyShare = 0.1;
/// Largest tracking error, m.
constexpr double kLargestTracking = 5e-3;
/// Largest displacement of the end effector by the null space, m.
constexpr double kLargestWandering = 2e-3;
/// Smallest null-space motion of a joint that demonstrates the effect, rad.
constexpr double kLeastWandering = 0.1;

void AddResponse(const Case& one, const Response& r, Evaluation& evaluation) {
  const auto named = [&one](std::string_view what) { return fmt::format("{}: {}", one.id, what); };
  evaluation.Add(named("deflection along the push, largest"), 1e3 * r.peak, "mm");
  evaluation.Demand(
      named("deflection under the constant force"), 1e3 * r.steady, "mm",
      fmt::format("F / K = {:.4g} mm within {:.0f} %", 1e3 * r.expected, 1e2 * kSteadyShare),
      std::abs(r.steady - r.expected) <= kSteadyShare * std::abs(r.expected));
  evaluation.Add(named("force of the push"), r.force, "N");
  evaluation.Add(named("force of the push, estimated by the robot"), r.estimated_steady, "N");
  if (r.settling) {
    evaluation.Add(named("settling time to a tenth, after the end of the push"), *r.settling, "s");
  } else {
    evaluation.Add(named("not settled to a tenth by the end of the motion, after"),
                   r.t.back() - r.t.front(), "s");
  }
}

void AddTracking(CaseIndex index, const Tracking& t, Evaluation& evaluation) {
  const auto id = kAllCases[index].id;
  const auto most = index == kC0 ? std::optional(1e3 * kLargestTracking) : std::nullopt;
  evaluation.DemandAtMost(fmt::format("{}: tracking error, largest", id), 1e3 * t.largest, "mm",
                          most);
  evaluation.Add(fmt::format("{}: tracking error, RMS", id), 1e3 * t.rms, "mm");
  evaluation.Add(fmt::format("{}: orientation error, largest", id), 1e3 * t.largest_turned, "mrad");
}

constexpr std::uint64_t kEvery = 5;  ///< cycles between the points of a path

/// The same push on a stiff and on a compliant arm.
report::Figure PushedFigure(std::string id, CaseIndex stiff, CaseIndex compliant,
                            const Measures& m) {
  report::Figure figure{
      .id = std::move(id),
      .plot = "standstill",
      .columns = "case,t [s],along [mm],across [mm],push [N],estimated [N],push / stiffness [mm]"};
  for (const CaseIndex index : {stiff, compliant}) {
    const Case& one = kAllCases[index];
    const Response& r = *m.responses[index];
    figure.names.push_back(fmt::format("{}: {}", one.id, one.what));
    for (std::size_t i = 0; i < r.t.size(); ++i) {
      figure.rows.push_back({index == stiff ? 0.0 : 1.0, r.t[i], 1e3 * r.along[i],
                             1e3 * r.across[i], r.scripted[i], r.estimated[i],
                             1e3 * r.expected * r.scripted[i] / r.force});
    }
  }
  return figure;
}

/// Position and reference of the end effector, relative to its start.
report::Figure TrajectoryFigure(const Log& log) {
  report::Figure figure{.id = "trajectory",
                        .columns = "case,t [s],x [mm],y [mm],z [mm],x_d [mm],y_d [mm],z_d [mm]"};
  for (const CaseIndex index : {kD, kC, kC0}) {
    figure.names.emplace_back(kAllCases[index].id);
    const Trace& trace = log.traces[index];
    for (const Sample& sample : trace) {
      if (sample.cycle % kEvery != 0) continue;
      std::vector<double>& row = figure.rows.emplace_back(
          std::vector{static_cast<double>(figure.names.size()), sample.t()});
      for (const bool desired : {false, true}) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double begin = trace.front().p[axis] - trace.front().off[axis];
          const double off = desired ? sample.off[axis] : 0;
          row.push_back(1e3 * (sample.p[axis] - off - begin));
        }
      }
    }
  }
  return figure;
}

report::Figure TrackingFigure(const Log& log) {
  report::Figure figure{.id = "tracking", .columns = "case,t [s],error [mm]"};
  for (const CaseIndex index : {kC0, kD0}) {
    figure.names.push_back(fmt::format("{}: {}", kAllCases[index].id, kAllCases[index].what));
    for (const Sample& s : log.traces[index]) {
      if (s.cycle % kEvery != 0) continue;
      figure.rows.push_back({static_cast<double>(figure.names.size()), s.t(),
                             1e3 * std::hypot(s.off[0], s.off[1], s.off[2])});
    }
  }
  return figure;
}

report::Figure NullSpaceFigure(const Trace& trace, const Config& config) {
  const double begin = WanderingBegin(config);
  report::Figure figure{.id = "null_space", .columns = "t [s]", .values = {{"begin", begin}}};
  for (std::size_t j = 1; j <= kJoints; ++j) figure.columns += fmt::format(",joint {} [rad]", j);
  figure.columns += ",end effector [mm]";
  const auto first = std::ranges::find_if(trace, [&](const Sample& s) { return s.t() >= begin; });
  const Vector3 from = first == trace.end() ? trace.front().p : first->p;
  for (const Sample& s : trace) {
    if (s.cycle % kEvery != 0) continue;
    std::vector<double>& row = figure.rows.emplace_back(1, s.t());
    for (std::size_t j = 0; j < kJoints; ++j) row.push_back(s.q[j] - trace.front().q[j]);
    row.push_back(1e3 * std::hypot(s.p[0] - from[0], s.p[1] - from[1], s.p[2] - from[2]));
  }
  return figure;
}

/// Torques and their rates over the session; a gap ends each case.
report::Figure TorquesFigure(const Log& log) {
  report::Figure figure{.id = "torques", .columns = "stiff,t [s],torque [%],rate [%]"};
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < kCases; ++i) {
    const double stiff = kAllCases[i].is_stiff ? 1 : 0;
    for (const Sample& s : log.traces[i]) {
      figure.rows.push_back({stiff, s.at, 1e2 * s.torque, 1e2 * s.rate});
    }
    figure.rows.push_back({stiff, kNone, kNone, kNone});
  }
  return figure;
}

}  // namespace

std::vector<report::Figure> FiguresOf(const Log& log, const Measures& m, const Config& config) {
  std::vector<report::Figure> figures;
  if (m.responses[kA] && m.responses[kB]) {
    figures.push_back(PushedFigure("standstill", kA, kB, m));
  }
  if (m.responses[kC] && m.responses[kD]) figures.push_back(PushedFigure("pushed", kC, kD, m));
  if (!log.traces[kC0].empty()) {
    figures.push_back(TrajectoryFigure(log));
    figures.push_back(TrackingFigure(log));
  }
  if (m.wandering) figures.push_back(NullSpaceFigure(log.traces[kN], config));
  if (!log.traces[kA].empty()) figures.push_back(TorquesFigure(log));
  if (m.responses[kB]) {
    report::Figure& friction = figures.emplace_back(report::Figure{.id = "friction"});
    if (const auto& share = config.friction_compensation) {
      friction.values["percent"] = std::round(1e2 * *share);
    }
  }
  return figures;
}

Evaluation EvaluateCases(const Measures& m) {
  Evaluation evaluation;
  for (const auto& [stiff, compliant] : {std::pair(kA, kB), {kC, kD}}) {
    for (const CaseIndex index : {stiff, compliant}) {
      if (m.responses[index]) AddResponse(kAllCases[index], *m.responses[index], evaluation);
    }
    if (!m.responses[stiff] || !m.responses[compliant]) continue;
    const double share = m.responses[stiff]->peak / m.responses[compliant]->peak;
    evaluation.Demand(fmt::format("{}: largest deflection / that of {}", kAllCases[stiff].id,
                                  kAllCases[compliant].id),
                      share, "", fmt::format("below {}", kStiffShare), share < kStiffShare);
  }
  for (const CaseIndex index : {kC0, kD0}) {
    if (m.trackings[index]) AddTracking(index, *m.trackings[index], evaluation);
  }
  if (m.wandering) {
    evaluation.Demand("N: joint motion in the null space, largest", m.wandering->joints, "rad",
                      fmt::format("at least {} rad", kLeastWandering),
                      m.wandering->joints >= kLeastWandering);
    evaluation.DemandAtMost("N: end effector motion meanwhile, largest",
                            1e3 * m.wandering->end_effector, "mm", 1e3 * kLargestWandering);
  }
  evaluation.DemandAtMost("peak torque / limit, measured or commanded", 1e2 * m.torque, "%", 100);
  evaluation.DemandAtMost("peak rate of the commanded torque / limit", 1e2 * m.rate, "%", 100);
  evaluation.DemandAtMost("reflexes", static_cast<double>(m.reflexes), "", 0);
  return evaluation;
}

}  // namespace twin::application::compliance

#include "application/compliance_figures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace twin::application::compliance {
namespace {

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

/// Positions and reference of the end effector, from where it stood.
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

report::Figure NullSpaceFigure(const Trace& trace, const Settings& settings) {
  const double begin = WanderingBegin(settings);
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

report::Figure FrictionFigure(const Settings& settings) {
  report::Figure figure{.id = "friction"};
  if (settings.friction_compensation) {
    figure.values["percent"] = std::round(1e2 * *settings.friction_compensation);
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

std::vector<report::Figure> FiguresOf(const Log& log, const Measures& m, const Settings& settings) {
  std::vector<report::Figure> figures;
  if (m.responses[kA] && m.responses[kB]) {
    figures.push_back(PushedFigure("standstill", kA, kB, m));
  }
  if (m.responses[kC] && m.responses[kD]) figures.push_back(PushedFigure("pushed", kC, kD, m));
  if (!log.traces[kC0].empty()) {
    figures.push_back(TrajectoryFigure(log));
    figures.push_back(TrackingFigure(log));
  }
  if (m.wandering) figures.push_back(NullSpaceFigure(log.traces[kN], settings));
  if (!log.traces[kA].empty()) figures.push_back(TorquesFigure(log));
  if (m.responses[kB]) figures.push_back(FrictionFigure(settings));
  return figures;
}

}  // namespace twin::application::compliance

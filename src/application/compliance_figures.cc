#include "application/compliance_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "twin/report/chart.h"

namespace twin::application::compliance {
namespace {

using report::Chart;
using report::ChartCurve;
using report::ChartPanel;

constexpr std::string_view kStiffColour = report::colour::kBare;
constexpr std::string_view kCompliantColour = report::colour::kAsynchronous;
constexpr std::string_view kTouchedColour = report::colour::kSynchronous;
constexpr std::string_view kScriptColour = report::colour::kReference;

ChartCurve CurveOf(std::string name, std::string_view colour, const std::vector<double>& x,
                   const std::vector<double>& y, double scale = 1) {
  ChartCurve curve{.name = std::move(name), .colour = colour, .x = x, .y = y};
  for (double& value : curve.y) value *= scale;
  return curve;
}

/// A value of every sample.
template <typename Get>
ChartCurve CurveOf(std::string name, std::string_view colour, const Trace& trace, Get get) {
  ChartCurve curve{.name = std::move(name), .colour = colour};
  for (const Sample& sample : trace) {
    curve.x.push_back(sample.t());
    curve.y.push_back(get(sample));
  }
  return curve;
}

/// Lowest and highest of what two panels show, with some room, so that they have the same axis.
std::array<double, 2> CommonRange(const ChartPanel& a, const ChartPanel& b) {
  double low = 0;
  double high = 0;
  for (const ChartPanel* panel : {&a, &b}) {
    for (const ChartCurve& curve : panel->curves) {
      for (const double y : curve.y) {
        low = std::min(low, y);
        high = std::max(high, y);
      }
    }
  }
  const double room = 0.06 * (high - low);
  return {low - room, high + room};
}

ChartPanel DeflectionPanel(const Case& one, const Response& r) {
  ChartPanel panel{.title = fmt::format("{}: {}", one.id, one.what),
                   .x_label = "t [s]",
                   .y_label = "deflection [mm]"};
  panel.curves.push_back(
      CurveOf("along the push", one.is_stiff ? kStiffColour : kCompliantColour, r.t, r.along, 1e3));
  panel.curves.push_back(CurveOf("across", report::colour::kSeries[3], r.t, r.across, 1e3));
  ChartCurve expected =
      CurveOf("F(t) / K", report::colour::kLimit, r.t, r.scripted, 1e3 * r.expected / r.force);
  expected.style = ChartCurve::Style::kDashed;
  panel.curves.push_back(std::move(expected));
  return panel;
}

ChartPanel ForcePanel(const Response& r) {
  ChartPanel panel{.x_label = "t [s]", .y_label = "force [N]"};
  panel.curves.push_back(
      CurveOf("as the robot estimates it", report::colour::kSeries[4], r.t, r.estimated));
  ChartCurve scripted = CurveOf("of the push", kScriptColour, r.t, r.scripted);
  scripted.style = ChartCurve::Style::kDashed;
  panel.curves.push_back(std::move(scripted));
  return panel;
}

/// Stiff beside compliant, on the same axes.
Figure PushedFigure(std::string id, std::string title, const Case& stiff, const Case& compliant,
                    const Response& a, const Response& b) {
  Chart chart{.columns = 2,
              .panels = {DeflectionPanel(stiff, a), DeflectionPanel(compliant, b), ForcePanel(a),
                         ForcePanel(b)}};
  for (const std::size_t i : {0U, 2U}) {
    chart.panels[i].y_range = CommonRange(chart.panels[i], chart.panels[i + 1]);
    chart.panels[i + 1].y_range = chart.panels[i].y_range;
  }
  return {
      .id = std::move(id),
      .title = std::move(title),
      .what = fmt::format("The same push on {} and {}: above how far the end effector gives way, "
                          "below the force.",
                          stiff.id, compliant.id),
      .svg = report::DrawChart(chart)};
}

/// The trajectory along one axis, from where the arm stood.
ChartPanel AxisPanel(std::size_t axis, const Log& log) {
  ChartPanel panel{.x_label = "t [s]", .y_label = fmt::format("{} [mm]", "xyz"[axis])};
  const auto measured = [&](CaseIndex index, std::string_view colour) {
    const Trace& trace = log.traces[index];
    if (trace.empty()) return;
    const double begin = trace.front().p[axis] - trace.front().off[axis];
    panel.curves.push_back(
        CurveOf(std::string(kAllCases[index].id), colour, trace,
                [axis, begin](const Sample& s) { return 1e3 * (s.p[axis] - begin); }));
  };
  measured(kD, kCompliantColour);
  measured(kC, kTouchedColour);
  measured(kC0, kStiffColour);
  const Trace& untouched = log.traces[kC0];
  const double begin = untouched.front().p[axis] - untouched.front().off[axis];
  ChartCurve reference =
      CurveOf("reference", report::colour::kLimit, untouched,
              [axis, begin](const Sample& s) { return 1e3 * (s.p[axis] - s.off[axis] - begin); });
  reference.style = ChartCurve::Style::kDashed;
  panel.curves.push_back(std::move(reference));
  return panel;
}

Figure PathFigure(const Log& log) {
  Chart chart;
  chart.panel_height = 220;
  for (std::size_t axis = 0; axis < 3; ++axis) chart.panels.push_back(AxisPanel(axis, log));
  return {.id = "trajectory",
          .title = "The trajectory: stiff untouched, stiff pushed, compliant pushed",
          .what = "Where the end effector was, from where it stood, and where it was to be.",
          .svg = report::DrawChart(chart)};
}

Figure TrackingFigure(const Log& log) {
  ChartPanel panel{.x_label = "t [s]", .y_label = "distance [mm]"};
  const auto off = [](const Sample& s) { return 1e3 * std::hypot(s.off[0], s.off[1], s.off[2]); };
  for (const auto& [index, colour] :
       {std::pair(kC0, kStiffColour), std::pair(kD0, kCompliantColour)}) {
    if (log.traces[index].empty()) continue;
    panel.curves.push_back(
        CurveOf(fmt::format("{}: {}", kAllCases[index].id, kAllCases[index].what), colour,
                log.traces[index], off));
  }
  return {.id = "tracking",
          .title = "Distance from the trajectory, untouched",
          .what = "What is left to inertia, friction and weight that the robot does not know of.",
          .svg = report::DrawChart({.panels = {std::move(panel)}})};
}

Figure NullSpaceFigure(const Trace& trace, const Settings& settings) {
  ChartPanel joints{.x_label = "t [s]", .y_label = "q - q(0) [rad]"};
  for (std::size_t j = 0; j < kJoints; ++j) {
    joints.curves.push_back(CurveOf(
        fmt::format("joint {}", j + 1), report::colour::kSeries[j % report::colour::kSeries.size()],
        trace, [&, j](const Sample& s) { return s.q[j] - trace.front().q[j]; }));
  }
  joints.curves.back().style = ChartCurve::Style::kDashed;
  const double begin = WanderingBegin(settings);
  const auto first = std::ranges::find_if(trace, [&](const Sample& s) { return s.t() >= begin; });
  ChartPanel away{.x_label = "t [s]", .y_label = "end effector [mm]"};
  const Vector3 from = first == trace.end() ? trace.front().p : first->p;
  away.curves.push_back(CurveOf("", kStiffColour, trace, [&](const Sample& s) {
    return 1e3 * std::hypot(s.p[0] - from[0], s.p[1] - from[1], s.p[2] - from[2]);
  }));
  Chart chart{.panels = {std::move(joints), std::move(away)}};
  return {
      .id = "null_space",
      .title = "N: the null space moves the joints, not the end effector",
      .what = fmt::format("Above the joints; below the end effector's distance from where it was "
                          "{:.1f} s after the motion began, once the soft start was over.",
                          begin),
      .svg = report::DrawChart(chart)};
}

/// What a share of friction compensation does to the compliant arm at a site whose joints run
/// freely (lab a), and at one whose joints have the model's friction: measured, see
/// models/applications/README.md.
struct Swinging {
  double share;  ///< of the model's friction, that the controller adds
  double free;   ///< mm, half of peak to peak, 16 to 21 s after a push of 10 N
  double dry;    ///< mm
};
constexpr std::array<Swinging, 9> kSwinging{{{0, 0.0, 0.0},
                                             {0.1, 0.1, 0.0},
                                             {0.2, 0.5, 0.0},
                                             {0.3, 2.4, 0.0},
                                             {0.4, 12, 0.0},
                                             {0.5, 34, 0.0},
                                             {0.6, 53, 0.0},
                                             {0.8, 87, 0.0},
                                             {1, 121, 0.0}}};

Figure FrictionFigure(const Settings& settings) {
  ChartCurve free{.name = "joints that run freely (lab a)", .colour = kTouchedColour};
  ChartCurve dry{.name = "joints with the model's friction", .colour = kCompliantColour};
  for (const Swinging& one : kSwinging) {
    for (ChartCurve* curve : {&free, &dry}) curve->x.push_back(1e2 * one.share);
    free.y.push_back(one.free);
    dry.y.push_back(one.dry);
  }
  ChartPanel panel{.x_label = "friction compensated [% of the model's]",
                   .y_label = "swinging [mm]",
                   .curves = {std::move(free), std::move(dry)}};
  const std::string here =
      settings.friction_compensation
          ? fmt::format("here it is {:.0f} %", 1e2 * *settings.friction_compensation)
          : "here it is what the robot leaves";
  return {.id = "friction",
          .title = "Why not all of the friction is compensated",
          .what = fmt::format(
              "How far the compliant arm still swings, either way, 16 s after a push of 10 N has "
              "ended, by the share of the model's friction that the controller adds; {}. What is "
              "compensated and not there drives the arm: where the joints run freely it swings "
              "without end from 50 % on, at 0.26 Hz, with all of it by 121 mm. Measured beforehand "
              "with the gains of models/applications/compliance.yaml, in lockstep, for 30 s.",
              here),
          .svg = report::DrawChart({.panels = {std::move(panel)}})};
}

/// A share of a limit over the session, in two colours.
ChartPanel SharePanel(const Log& log, std::string label, double Sample::*share) {
  ChartPanel panel{.x_label = "t [s]", .y_label = std::move(label)};
  for (const bool is_stiff : {true, false}) {
    ChartCurve curve{.name = is_stiff ? "stiff" : "compliant",
                     .colour = is_stiff ? kStiffColour : kCompliantColour};
    for (std::size_t i = 0; i < kCases; ++i) {
      if (kAllCases[i].is_stiff != is_stiff || log.traces[i].empty()) continue;
      for (const Sample& sample : log.traces[i]) {
        curve.x.push_back(sample.at);
        curve.y.push_back(1e2 * sample.*share);
      }
      curve.x.push_back(log.traces[i].back().at);
      curve.y.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    panel.curves.push_back(std::move(curve));
  }
  return panel;
}

Figure TorqueFigure(const Log& log) {
  Chart chart{.panels = {SharePanel(log, "torque [% of its limit]", &Sample::torque),
                         SharePanel(log, "its rate [% of its limit]", &Sample::rate)}};
  chart.panel_height = 220;
  return {.id = "torques",
          .title = "Torques and their rates",
          .what =
              "Of the joint that is nearest to its limit; the cases one after the other, without "
              "the ways back.",
          .svg = report::DrawChart(chart)};
}

}  // namespace

std::vector<Figure> FiguresOf(const Log& log, const Measures& m, const Settings& settings) {
  std::vector<Figure> figures;
  if (m.responses[kA] && m.responses[kB]) {
    figures.push_back(PushedFigure("standstill", "Pushed at a standstill", kAllCases[kA],
                                   kAllCases[kB], *m.responses[kA], *m.responses[kB]));
  }
  if (m.responses[kC] && m.responses[kD]) {
    figures.push_back(PushedFigure("pushed", "Pushed on the trajectory", kAllCases[kC],
                                   kAllCases[kD], *m.responses[kC], *m.responses[kD]));
  }
  if (!log.traces[kC0].empty()) {
    figures.push_back(PathFigure(log));
    figures.push_back(TrackingFigure(log));
  }
  if (m.wandering) figures.push_back(NullSpaceFigure(log.traces[kN], settings));
  if (!log.traces[kA].empty()) figures.push_back(TorqueFigure(log));
  if (m.responses[kB]) figures.push_back(FrictionFigure(settings));
  return figures;
}

}  // namespace twin::application::compliance

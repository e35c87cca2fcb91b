#include "application/pick_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/core/modes.h"
#include "twin/record/log_reader.h"
#include "twin/report/chart.h"

namespace twin::application {
namespace {

using report::ChartCurve;
using report::ChartPanel;

constexpr std::uint64_t kSampleCycles = 5;

/// Takes the states of a log one after the other.
class Collector {
 public:
  Collector(const JointLimits& limits, PickTrace& trace) : limits_(limits), trace_(trace) {}

  void operator()(const rt::CycleRecord& cycle) {
    const RobotState& state = cycle.state;
    if (state.robot_mode == RobotMode::kMove) {
      for (std::size_t i = 0; i < kJoints; ++i) {
        velocity_ = std::max(velocity_, std::abs(state.dq_d[i]) / limits_.dq_max[i]);
        acceleration_ = std::max(acceleration_, std::abs(state.ddq_d[i]) / limits_.ddq_max[i]);
        jerk_ = std::max(jerk_, std::abs(cycle.dddq_d[i]) / limits_.dddq_max[i]);
      }
    }
    if (cycles_++ % kSampleCycles != 0) return;
    trace_.t.push_back(ToSeconds(cycle.at.time_since_epoch()));
    for (std::size_t i = 0; i < 3; ++i) trace_.p[i].push_back(state.O_T_EE[12 + i]);
    trace_.velocity.push_back(std::exchange(velocity_, 0));
    trace_.acceleration.push_back(std::exchange(acceleration_, 0));
    trace_.jerk.push_back(std::exchange(jerk_, 0));
    trace_.force.push_back(-state.O_F_ext_hat_K[2]);
  }
  template <typename Other>
  void operator()(const Other& /*record*/) {}

 private:
  const JointLimits& limits_;
  PickTrace& trace_;
  std::uint64_t cycles_ = 0;
  double velocity_ = 0;
  double acceleration_ = 0;
  double jerk_ = 0;
};

ChartCurve CurveOf(std::string name, std::size_t colour, const std::vector<double>& x,
                   const std::vector<double>& y, double scale) {
  ChartCurve curve{
      .name = std::move(name), .colour = report::colour::kSeries[colour], .x = x, .y = y};
  for (double& value : curve.y) value *= scale;
  return curve;
}

ChartPanel PathPanel(const PickTrace& trace, const plant::ObjectTrack* track) {
  ChartPanel panel{.x_label = "t [s]", .y_label = "[m]"};
  for (std::size_t i = 0; i < 3; ++i) {
    panel.curves.push_back(
        CurveOf(fmt::format("end effector {}", "xyz"[i]), i, trace.t, trace.p[i], 1));
  }
  if (track == nullptr) return panel;
  ChartCurve height{
      .name = "object z", .colour = report::colour::kLimit, .style = ChartCurve::Style::kDashed};
  for (const plant::ObjectSample& sample : track->samples) {
    height.x.push_back(ToSeconds(sample.at.time_since_epoch()));
    height.y.push_back(sample.X_WB[14]);
  }
  panel.curves.push_back(std::move(height));
  return panel;
}

}  // namespace

PickTrace ReadPickTrace(const std::filesystem::path& log, const JointLimits& limits) {
  PickTrace trace;
  record::LogReader reader(log);
  Collector collector(limits, trace);
  record::LogEntry entry;
  while (reader.Next(entry)) std::visit(collector, entry);
  return trace;
}

std::vector<Figure> PickFigures(const PickTrace& trace, const plant::ObjectTrack* track) {
  if (trace.t.empty()) return {};
  ChartPanel shares{.x_label = "t [s]", .y_label = "share of the limit [%]"};
  shares.curves = {CurveOf("velocity", 0, trace.t, trace.velocity, 1e2),
                   CurveOf("acceleration", 1, trace.t, trace.acceleration, 1e2)};
  ChartPanel jerk{.x_label = "t [s]", .y_label = "jerk, share of the limit [%]"};
  jerk.curves = {CurveOf("", 2, trace.t, trace.jerk, 1e2)};
  ChartPanel force{.x_label = "t [s]", .y_label = "force [N]"};
  force.curves = {CurveOf("", 4, trace.t, trace.force, 1)};
  return {
      {.id = "path",
       .title = "Where the hand was",
       .what = "The end effector as the robot measured it, in the base frame; dashed how high "
               "the object was, where it is simulated.",
       .svg = report::DrawChart({.panels = {PathPanel(trace, track)}})},
      {.id = "limits",
       .title = "What the joints were asked for",
       .what = "Of the robot's reference the largest share of a joint's limit: what lost and "
               "doubled commands add shows as jerk.",
       .svg = report::DrawChart({.panel_height = 220, .panels = {shares, jerk}})},
      {.id = "force",
       .title = "What the hand felt",
       .what = "The vertical force from outside, as the robot estimates it, upwards on the hand; "
               "while it carries, what the object weighs beyond what the robot was told.",
       .svg = report::DrawChart({.panel_height = 220, .panels = {force}})}};
}

}  // namespace twin::application

#include "application/teleoperation_evaluation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/half_norm.h"
#include "twin/report/chart.h"

namespace twin::application {
namespace {

using plant::ObjectTrack;
using report::ChartCurve;
using report::ChartPanel;
using teleop::TeleoperatorStatus;

constexpr double kMostDistance = 0.03;  // m, from the target
constexpr double kMostError = 0.01;     // m, of the arm on a base that drives
/// Rounding of third differences, and what a session's own clock drifts.
constexpr double kRounding = 1.02;
constexpr double kHandSpeed = 0.2;  // m/s, of a quick hand
constexpr double kMostTilt = 0.05;  // of the object's axis: 1 - cos, some 18 degrees

void Demand(Evaluation& evaluation, std::string quantity, double value, std::string unit,
            double most) {
  evaluation.findings.push_back(
      {.quantity = std::move(quantity),
       .value = value,
       .unit = unit,
       .demand = most == 0 ? "none"
                           : fmt::format("at most {:g}{}{}", most, unit.empty() ? "" : " ", unit),
       .met = value <= most});
}

void Tell(Evaluation& evaluation, std::string quantity, double value, std::string unit = "") {
  evaluation.findings.push_back(
      {.quantity = std::move(quantity), .value = value, .unit = std::move(unit)});
}

void EvaluateObject(const FetchTask& task, const Evidence& evidence, Evaluation& evaluation) {
  if (evidence.contacts == nullptr || task.object.empty()) return;
  const std::vector<ObjectTrack> tracks = evidence.contacts->objects().Tracks();
  const auto track = std::ranges::find(tracks, task.object, &ObjectTrack::body);
  if (track == tracks.end()) return;
  const Transform& X = track->last.X_WB;
  Demand(evaluation, "the object's distance from its target in the end",
         1e3 * std::hypot(X[12] - task.to[0], X[13] - task.to[1], X[14] - task.to[2]), "mm",
         1e3 * kMostDistance);
  Demand(evaluation, "it leans in the end, 1 - cos", 1 - X[10], "", kMostTilt);
  const plant::Support& now = track->changes.back().now;
  Demand(evaluation, "fingers that still touch it",
         static_cast<double>(now.left_finger) + static_cast<double>(now.right_finger), "", 0);
}

void EvaluateCommands(const TeleoperationRecord& record, Evaluation& evaluation) {
  const TeleoperatorStatus& end = record.trace.back();
  const teleop::TeleoperatorConfig& most = record.config;
  Demand(evaluation, "the arm's distance from its reference while the base was led, at most",
         1e3 * end.most_drive_error, "mm", 1e3 * kMostError);
  Demand(evaluation, "jerk of the arm's reference at switches of the mode",
         end.peaks_at_switch.along.jerk, "m/s^3", kRounding * most.along.jerk);
  Demand(evaluation, "jerk of the base's command at switches of the mode",
         end.peaks_at_switch.ahead.jerk, "m/s^3", kRounding * most.ahead.jerk);
  Demand(evaluation, "jerk of the arm's reference", end.peaks.along.jerk, "m/s^3",
         kRounding * most.along.jerk);
  Demand(evaluation, "jerk of the base's command", end.peaks.ahead.jerk, "m/s^3",
         kRounding * most.ahead.jerk);
  Tell(evaluation, "speed of the arm's reference, at most", end.peaks.along.speed, "m/s");
  Tell(evaluation, "speed of the base's command, at most", end.peaks.ahead.speed, "m/s");
  // On top of the reserve comes what a hand gets that turns around within a period.
  const double turned = most.feedback.most_force * kHandSpeed * kCycleSeconds;
  Demand(evaluation, "energy the operator's port gave on any axis",
         1e3 * std::max(0.0, -end.least_energy), "mJ", 1e3 * (most.feedback.reserve + turned));
}

ChartCurve CurveOf(const TeleoperationRecord& record, std::string name, std::size_t colour,
                   const std::function<double(const TeleoperatorStatus&)>& value) {
  ChartCurve curve{.name = std::move(name), .colour = report::colour::kSeries[colour]};
  for (const TeleoperatorStatus& status : record.trace) {
    curve.x.push_back(ToSeconds(status.now.time_since_epoch()));
    curve.y.push_back(value(status));
  }
  return curve;
}

std::vector<Figure> FiguresOf(const TeleoperationRecord& record) {
  ChartPanel base{.x_label = "t [s]", .y_label = "base [m/s, rad/s]"};
  base.curves = {CurveOf(record, "ahead", 0, [](const auto& s) { return s.base_twist.v; }),
                 CurveOf(record, "turning", 1, [](const auto& s) { return s.base_twist.w; })};
  ChartPanel arm{.x_label = "t [s]", .y_label = "arm's reference [m/s]"};
  arm.curves = {
      CurveOf(record, "", 2, [](const auto& s) { return HalfNorm(s.target.O_dP_EE, 0); })};
  ChartPanel error{.x_label = "t [s]", .y_label = "arm off its reference [mm]"};
  error.curves = {CurveOf(record, "", 3, [](const auto& s) { return 1e3 * s.arm_error; })};
  ChartPanel felt{.x_label = "t [s]", .y_label = "force at the handle [N]"};
  felt.curves = {CurveOf(record, "", 4, [](const auto& s) { return HalfNorm(s.felt, 0); })};
  ChartPanel energy{.x_label = "t [s]", .y_label = "energy put in at the port [mJ]"};
  for (std::size_t i = 0; i < 3; ++i) {
    energy.curves.push_back(CurveOf(record, fmt::format("{}", "xyz"[i]), i,
                                    [i](const auto& s) { return 1e3 * s.energy[i]; }));
  }
  return {{.id = "led",
           .title = "What was led",
           .what = "Commands to the base and the speed of the arm's reference: one at a time, each "
                   "at rest before the other begins.",
           .svg = report::DrawChart({.panel_height = 200, .panels = {base, arm}})},
          {.id = "error",
           .title = "How well the arm held",
           .what = "Distance of the measured end effector from its reference, relative to the "
                   "base: also while that drives.",
           .svg = report::DrawChart({.panel_height = 200, .panels = {error}})},
          {.id = "port",
           .title = "What the operator felt",
           .what = "Force at the handle, and the energy that was put in there less what came out.",
           .svg = report::DrawChart({.panel_height = 200, .panels = {felt, energy}})}};
}

}  // namespace

Evaluation EvaluateTeleoperation(const TeleoperationRecord& record, const Evidence& evidence) {
  Evaluation evaluation;
  Demand(evaluation,
         record.robot_errors.empty()
             ? "errors of the robot"
             : fmt::format("errors of the robot: {}", fmt::join(record.robot_errors, "; ")),
         static_cast<double>(record.robot_errors.size()), "", 0);
  EvaluateObject(record.task, evidence, evaluation);
  if (record.trace.empty()) return evaluation;
  EvaluateCommands(record, evaluation);
  Tell(evaluation, "switches of the mode", record.switches);
  if (record.motions > 0) Tell(evaluation, "motions of the person", record.motions);
  const TeleoperatorStatus& end = record.trace.back();
  Tell(evaluation, "duration", ToSeconds(end.now.time_since_epoch()), "s");
  Tell(evaluation, "longest silence between two samples", 1e3 * ToSeconds(end.longest_silence),
       "ms");
  if (!evidence.log.empty()) evaluation.figures = FiguresOf(record);
  return evaluation;
}

}  // namespace twin::application

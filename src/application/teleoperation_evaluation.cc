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

namespace twin::application {
namespace {

using plant::ObjectTrack;
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
  Demand(evaluation, "object position error",
         1e3 * std::hypot(X[12] - task.to[0], X[13] - task.to[1], X[14] - task.to[2]), "mm",
         1e3 * kMostDistance);
  Demand(evaluation, "object tilt at the end, 1 - cos", 1 - X[10], "", kMostTilt);
  const plant::Support& now = track->changes.back().now;
  Demand(evaluation, "fingers in contact with the object at the end",
         static_cast<double>(now.left_finger) + static_cast<double>(now.right_finger), "", 0);
}

void EvaluateCommands(const TeleoperationRecord& record, Evaluation& evaluation) {
  const TeleoperatorStatus& end = record.trace.back();
  const teleop::TeleoperatorConfig& most = record.config;
  Demand(evaluation, "tracking error of the arm while the base drives, largest",
         1e3 * end.most_drive_error, "mm", 1e3 * kMostError);
  Demand(evaluation, "jerk of the arm's reference at mode switches", end.peaks_at_switch.along.jerk,
         "m/s^3", kRounding * most.along.jerk);
  Demand(evaluation, "jerk of the base's command at mode switches", end.peaks_at_switch.ahead.jerk,
         "m/s^3", kRounding * most.ahead.jerk);
  Demand(evaluation, "jerk of the arm's reference", end.peaks.along.jerk, "m/s^3",
         kRounding * most.along.jerk);
  Demand(evaluation, "jerk of the base's command", end.peaks.ahead.jerk, "m/s^3",
         kRounding * most.ahead.jerk);
  Tell(evaluation, "speed of the arm's reference, largest", end.peaks.along.speed, "m/s");
  Tell(evaluation, "speed of the base's command, largest", end.peaks.ahead.speed, "m/s");
  // On top of the reserve comes what a hand gets that turns around within a period.
  const double turned = most.feedback.most_force * kHandSpeed * kCycleSeconds;
  Demand(evaluation, "energy out of the operator's port, largest of the axes",
         1e3 * std::max(0.0, -end.least_energy), "mJ", 1e3 * (most.feedback.reserve + turned));
}

std::vector<report::Figure> FiguresOf(const TeleoperationRecord& record) {
  report::Figure led{.id = "led", .columns = "t [s],ahead [m/s],turning [rad/s],arm [m/s]"};
  report::Figure error{.id = "error", .columns = "t [s],error [mm]"};
  report::Figure port{.id = "port", .columns = "t [s],force [N],x [mJ],y [mJ],z [mJ]"};
  for (const TeleoperatorStatus& s : record.trace) {
    const double t = ToSeconds(s.now.time_since_epoch());
    led.rows.push_back({t, s.base_twist.v, s.base_twist.w, HalfNorm(s.target.O_dP_EE, 0)});
    error.rows.push_back({t, 1e3 * s.arm_error});
    port.rows.push_back(
        {t, HalfNorm(s.felt, 0), 1e3 * s.energy[0], 1e3 * s.energy[1], 1e3 * s.energy[2]});
  }
  return {std::move(led), std::move(error), std::move(port)};
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
  Tell(evaluation, "mode switches", record.switches);
  if (record.motions > 0) Tell(evaluation, "motions by the operator", record.motions);
  const TeleoperatorStatus& end = record.trace.back();
  Tell(evaluation, "duration", ToSeconds(end.now.time_since_epoch()), "s");
  Tell(evaluation, "longest gap between two samples", 1e3 * ToSeconds(end.longest_silence), "ms");
  if (!evidence.log.empty()) evaluation.figures = FiguresOf(record);
  return evaluation;
}

}  // namespace twin::application

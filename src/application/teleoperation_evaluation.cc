#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "application/teleoperation.h"
#include "twin/core/joint_vector.h"

namespace twin::application {
namespace {

constexpr double kMostObjectError = 0.03;  // m, from the target
constexpr double kMostArmError = 0.01;     // m, of the arm on a base that drives
/// Margin for rounding of third differences and drift of the session's clock.
constexpr double kRounding = 1.02;
constexpr double kOperatorSpeed = 0.2;  // m/s, of a quick hand
constexpr double kMostTilt = 0.05;      // of the object's axis: 1 - cos, some 18 degrees

void EvaluateObject(const FetchTask& task, const Evidence& evidence, Evaluation& evaluation) {
  const std::optional<plant::ObjectTrack> track = evidence.TrackOf(task.object);
  if (!track) return;
  const Transform& X = track->last.X_WB;
  evaluation.DemandAtMost(
      "object position error",
      1e3 * std::hypot(X[12] - task.to[0], X[13] - task.to[1], X[14] - task.to[2]), "mm",
      1e3 * kMostObjectError);
  evaluation.DemandAtMost("object tilt at the end, 1 - cos", 1 - X[10], "", kMostTilt);
  const plant::Support& now = track->changes.back().now;
  evaluation.DemandAtMost(
      "fingers in contact with the object at the end",
      static_cast<double>(now.left_finger) + static_cast<double>(now.right_finger), "", 0);
}

void EvaluateCommands(const TeleoperationRecord& record, Evaluation& evaluation) {
  const teleop::TeleoperatorStatus& end = record.trace.back();
  const teleop::TeleoperatorConfig& most = record.config;
  evaluation.DemandAtMost("tracking error of the arm while the base drives, largest",
                          1e3 * end.most_drive_error, "mm", 1e3 * kMostArmError);
  evaluation.DemandAtMost("jerk of the arm's reference at mode switches",
                          end.peaks_at_switch.along.jerk, "m/s^3", kRounding * most.along.jerk);
  evaluation.DemandAtMost("jerk of the base's command at mode switches",
                          end.peaks_at_switch.ahead.jerk, "m/s^3", kRounding * most.ahead.jerk);
  evaluation.DemandAtMost("jerk of the arm's reference", end.peaks.along.jerk, "m/s^3",
                          kRounding * most.along.jerk);
  evaluation.DemandAtMost("jerk of the base's command", end.peaks.ahead.jerk, "m/s^3",
                          kRounding * most.ahead.jerk);
  evaluation.Report("speed of the arm's reference, largest", end.peaks.along.speed, "m/s");
  evaluation.Report("speed of the base's command, largest", end.peaks.ahead.speed, "m/s");
  // A hand that reverses within one period gets more than the reserve (PassivePort).
  const double turned = most.feedback.most_force * kOperatorSpeed * kCycleSeconds;
  evaluation.DemandAtMost("energy out of the operator's port, largest of the axes",
                          1e3 * std::max(0.0, -end.least_energy), "mJ",
                          1e3 * (most.feedback.reserve + turned));
}

std::vector<report::Figure> TeleoperationFigures(const TeleoperationRecord& record) {
  report::Figure led{.id = "led", .columns = "t [s],ahead [m/s],turning [rad/s],arm [m/s]"};
  report::Figure error{.id = "error", .columns = "t [s],error [mm]"};
  report::Figure port{.id = "port", .columns = "t [s],force [N],x [mJ],y [mJ],z [mJ]"};
  for (const teleop::TeleoperatorStatus& s : record.trace) {
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
  evaluation.DemandNone("errors of the robot", record.robot_errors);
  EvaluateObject(record.task, evidence, evaluation);
  if (record.trace.empty()) return evaluation;
  EvaluateCommands(record, evaluation);
  evaluation.Report("mode switches", record.switches);
  if (record.motions > 0) evaluation.Report("motions by the operator", record.motions);
  const teleop::TeleoperatorStatus& end = record.trace.back();
  evaluation.Report("duration", ToSeconds(end.now.time_since_epoch()), "s");
  evaluation.Report("longest gap between two samples", 1e3 * ToSeconds(end.longest_silence), "ms");
  if (!evidence.log.empty()) evaluation.figures = TeleoperationFigures(record);
  return evaluation;
}

}  // namespace twin::application

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Core>

#include "application/pick.h"
#include "twin/core/modes.h"
#include "twin/model/transform.h"
#include "twin/record/log_reader.h"

namespace twin::application {
namespace {

using plant::ObjectTrack;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMostPositionError = 5e-3;      // m
constexpr double kMostAngleError = 3 * kDegree;  // rad
constexpr double kStillSpeed = 1e-3;             // m/s
constexpr double kStillTurnRate = kDegree;       // rad/s
constexpr double kLongestFallMs = 20;            // of a fall of 2 mm
constexpr double kLeastHeldByBothMs = 100;       // longer than a finger's rebound
constexpr std::uint64_t kCyclesPerSample = 5;

double PositionError(const Transform& a, const Transform& b) {
  return (model::Position(a) - model::Position(b)).norm();
}

double AngleError(const Transform& a, const Transform& b) {
  return model::TurnBetween(a, b).norm();
}

/// The object's pose in the base.
Transform InBase(const PickTask& task, const Transform& X_WB) {
  return model::Multiply(model::Inverse(task.X_WO), X_WB);
}

/// The longest time without support by the surroundings or by both fingers.
Duration LongestFall(const ObjectTrack& track) {
  Duration longest{};
  for (std::size_t i = 0; i < track.changes.size(); ++i) {
    const plant::Support& now = track.changes[i].now;
    // Before the first step the object only touches its surface, without contact.
    if (i == 0 || now.world || now.between_fingers()) continue;
    const Time end = i + 1 < track.changes.size() ? track.changes[i + 1].at : track.last.at;
    longest = std::max(longest, end - track.changes[i].at);
  }
  return longest;
}

/// The longest interval in which the fingers alone hold the object; nullopt: none.
std::optional<std::pair<Time, Time>> WhenCarried(const ObjectTrack& track) {
  std::optional<std::pair<Time, Time>> carried;
  for (std::size_t i = 0; i + 1 < track.changes.size(); ++i) {
    const plant::Support& now = track.changes[i].now;
    if (now.world || !now.between_fingers()) continue;
    const auto [begin, end] = std::pair(track.changes[i].at, track.changes[i + 1].at);
    if (!carried || end - begin > carried->second - carried->first) carried = {begin, end};
  }
  return carried;
}

/// Motion of the object by the closing fingers, and in the hand during the transport.
void ReportSlip(const ObjectTrack& track, const PickTask& task, Evaluation& evaluation) {
  const auto carried = WhenCarried(track);
  if (!carried) return;
  Transform before = task.O_T_object;
  std::optional<Transform> first;
  double distance = 0;
  double angle = 0;
  for (const plant::ObjectSample& sample : track.samples) {
    if (sample.at <= carried->first) before = InBase(task, sample.X_WB);
    if (sample.at < carried->first || sample.at > carried->second) continue;
    if (!first) first = sample.X_HB;
    distance = std::max(distance, PositionError(*first, sample.X_HB));
    angle = std::max(angle, AngleError(*first, sample.X_HB));
  }
  evaluation.Add("displacement of the object by the grasp",
                 PositionError(task.O_T_object, before) * 1e3, "mm");
  evaluation.Add("slip of the object in the hand, largest", distance * 1e3, "mm");
  evaluation.Add("rotation of the object in the hand, largest", angle / kDegree, "deg");
}

/// Whether a part is a finger of the robot whose parts' names begin so.
bool IsFinger(std::string_view part, const std::string& prefix) {
  return part == prefix + "panda_leftfinger" || part == prefix + "panda_rightfinger";
}

std::vector<std::string> UnwantedContacts(const PickRecord& record, const Evidence& evidence,
                                          const ObjectTrack& track) {
  const PickTask& task = record.task;
  std::vector<std::string> unwanted;
  for (const plant::ContactPair& pair : evidence.contacts->Pairs()) {
    if (IsFinger(pair.a, evidence.prefix) && pair.b == task.object.name) continue;
    unwanted.push_back(fmt::format("{} and {}", pair.a, pair.b));
  }
  for (const plant::ObjectContact& contact : track.touched) {
    const std::string& part = contact.part;
    if (part == task.from || part == task.to || part == record.support) continue;
    if (!record.partner.empty() && IsFinger(part, record.partner + "/")) continue;
    unwanted.push_back(fmt::format("{} and {}", track.body, part));
  }
  return unwanted;
}

/// How long the fingers of both robots held the object together, until the partner let go.
Duration HeldByBoth(const ObjectTrack& track, const std::string& partner) {
  std::vector<Time> let_go;
  for (const plant::ObjectContact& contact : track.touched) {
    if (IsFinger(contact.part, partner + "/")) let_go.push_back(contact.last);
  }
  if (let_go.size() != 2) return Duration::zero();
  const Time until = std::ranges::min(let_go);
  bool holds = false;
  Time since{};
  for (const plant::SupportChange& change : track.changes) {
    if (change.at > until) break;
    if (change.now.between_fingers() && !holds) since = change.at;
    holds = change.now.between_fingers();
  }
  return holds ? until - since : Duration::zero();
}

/// What becomes of an object between two hands.
void EvaluateHandOver(const PickRecord& record, const ObjectTrack& track, Evaluation& evaluation) {
  if (!record.task.to.empty()) {
    const double held_ms = ToSeconds(HeldByBoth(track, record.partner)) * 1e3;
    evaluation.Demand("time in both hands", held_ms, "ms",
                      fmt::format("at least {:g} ms", kLeastHeldByBothMs),
                      held_ms >= kLeastHeldByBothMs);
    return;
  }
  const auto held_out =
      std::ranges::lower_bound(track.samples, record.offered, {}, &plant::ObjectSample::at);
  if (!record.is_placed || held_out == track.samples.end()) return;
  const Transform O_T_B = InBase(record.task, held_out->X_WB);
  evaluation.DemandAtMost("position error of the object as it is held out",
                          PositionError(O_T_B, record.task.O_T_goal) * 1e3, "mm",
                          kMostPositionError * 1e3);
  evaluation.DemandAtMost("orientation error of the object as it is held out",
                          AngleError(O_T_B, record.task.O_T_goal) / kDegree, "deg",
                          kMostAngleError / kDegree);
}

/// Where the object is at the end, by ground truth.
void EvaluateEnd(const PickTask& task, const plant::ObjectSample& end, Evaluation& evaluation) {
  const Transform O_T_B = InBase(task, end.X_WB);
  evaluation.DemandAtMost("object position error", PositionError(O_T_B, task.O_T_goal) * 1e3, "mm",
                          kMostPositionError * 1e3);
  evaluation.DemandAtMost("object orientation error", AngleError(O_T_B, task.O_T_goal) / kDegree,
                          "deg", kMostAngleError / kDegree);
  evaluation.DemandAtMost("object speed at the end", end.speed * 1e3, "mm/s", kStillSpeed * 1e3);
  evaluation.DemandAtMost("object turn rate at the end", end.turn_rate / kDegree, "deg/s",
                          kStillTurnRate / kDegree);
}

/// The object's motion, by ground truth.
void EvaluateTruth(const PickRecord& record, const Evidence& evidence, const ObjectTrack& track,
                   Evaluation& evaluation) {
  if (!record.task.to.empty()) EvaluateEnd(record.task, track.last, evaluation);
  evaluation.DemandAtMost("longest free fall of the object", ToSeconds(LongestFall(track)) * 1e3,
                          "ms", kLongestFallMs);
  evaluation.DemandNone("unwanted contacts", UnwantedContacts(record, evidence, track));
  if (!record.partner.empty()) EvaluateHandOver(record, track, evaluation);
  ReportSlip(track, record.task, evaluation);
}

/// The object's pose by the robot's joints. @param is_demanded  true without ground truth.
void EvaluateRelease(const PickRecord& record, bool is_demanded, Evaluation& evaluation) {
  if (!record.is_placed) return;
  const Transform O_T_object = model::Multiply(record.O_T_EE_placed, model::Inverse(record.B_T_EE));
  const auto at_most = [&](double most) {
    return is_demanded ? std::optional(most) : std::nullopt;
  };
  evaluation.DemandAtMost("position error at release, by the robot's joints",
                          PositionError(O_T_object, record.task.O_T_goal) * 1e3, "mm",
                          at_most(kMostPositionError * 1e3));
  evaluation.DemandAtMost("orientation error at release, by the robot's joints",
                          AngleError(O_T_object, record.task.O_T_goal) / kDegree, "deg",
                          at_most(kMostAngleError / kDegree));
  evaluation.Add("finger width after the grasp", record.width_grasped * 1e3, "mm");
  evaluation.Add("finger width before the release", record.width_placed * 1e3, "mm");
}

/// The figures `path`, `limits` and `force` from the states in a log, one sample per 5 ms. Shares
/// of the limits are the largest since the sample before. @throws as record::LogReader.
std::vector<report::Figure> PickFigures(const std::filesystem::path& log,
                                        const JointLimits& limits) {
  report::Figure path{.id = "path", .columns = "t [s],x [m],y [m],z [m]"};
  report::Figure shares{.id = "limits", .columns = "t [s],velocity,acceleration,jerk"};
  report::Figure force{.id = "force", .columns = "t [s],force [N]"};
  Vector3 share{};
  std::uint64_t cycles = 0;
  record::LogReader reader(log);
  for (record::LogEntry entry; reader.Next(entry);) {
    const auto* cycle = std::get_if<record::CycleRecord>(&entry);
    if (cycle == nullptr) continue;
    const RobotState& state = cycle->state;
    for (std::size_t i = 0; i < kJoints && state.robot_mode == RobotMode::kMove; ++i) {
      share[0] = std::max(share[0], std::abs(state.dq_d[i]) / limits.dq_max[i]);
      share[1] = std::max(share[1], std::abs(state.ddq_d[i]) / limits.ddq_max[i]);
      share[2] = std::max(share[2], std::abs(cycle->dddq_d[i]) / limits.dddq_max[i]);
    }
    if (cycles++ % kCyclesPerSample != 0) continue;
    const double t = ToSeconds(cycle->at.time_since_epoch());
    path.rows.push_back({t, state.O_T_EE[12], state.O_T_EE[13], state.O_T_EE[14]});
    shares.rows.push_back({t, share[0], share[1], share[2]});
    force.rows.push_back({t, -state.O_F_ext_hat_K[2]});
    share = {};
  }
  return {std::move(path), std::move(shares), std::move(force)};
}

/// Demands the limits of the reference and adds the figures. @param track  of the object; null:
/// none.
void EvaluateLog(const std::filesystem::path& log, const JointLimits& limits,
                 const ObjectTrack* track, Evaluation& evaluation) {
  std::vector<report::Figure> figures = PickFigures(log, limits);
  if (figures[0].rows.empty()) return;
  for (const auto& [name, column] : {std::pair("velocity", 1), {"acceleration", 2}, {"jerk", 3}}) {
    double largest = 0;
    for (const auto& row : figures[1].rows) {
      largest = std::max(largest, row[static_cast<std::size_t>(column)]);
    }
    evaluation.DemandAtMost(fmt::format("peak joint {} of the reference / limit", name),
                            largest * 1e2, "%", 100);
  }
  report::Table object{.columns = "t [s],z [m]"};
  if (track != nullptr) {
    for (const plant::ObjectSample& sample : track->samples) {
      object.rows.push_back({ToSeconds(sample.at.time_since_epoch()), sample.X_WB[14]});
    }
  }
  figures[0].tables["object"] = std::move(object);
  figures[0].values["simulated"] = track == nullptr ? 0 : 1;
  evaluation.figures = std::move(figures);
}

}  // namespace

Evaluation EvaluatePick(const PickRecord& record, const TaskResult& task_result,
                        const Evidence& evidence) {
  Evaluation evaluation;
  evaluation.DemandNone("errors of the robot", task_result.robot_errors);
  if (record.moved == Duration::zero()) return evaluation;  // no way was found
  if (const double error = PositionError(record.task.O_T_object, record.task.object.X_WB);
      error > 0) {
    evaluation.Add("perception error of the object's position", error * 1e3, "mm");
    evaluation.Add("perception error of the object's orientation",
                   AngleError(record.task.O_T_object, record.task.object.X_WB) / kDegree, "deg");
  }
  const std::optional<ObjectTrack> track = evidence.TrackOf(record.task.object.name);
  if (track) EvaluateTruth(record, evidence, *track, evaluation);
  EvaluateRelease(record, !track, evaluation);
  const auto failed = std::ranges::count(task_result.task.steps, false, &StepReport::succeeded);
  evaluation.Add("repeated or failed attempts", static_cast<double>(failed));
  evaluation.Add("planned duration of all motions", ToSeconds(record.moved), "s");
  if (evidence.session.counts.cycles() > 0) {
    evaluation.Add("unserved cycles", evidence.session.counts.unserved_percent(), "%");
  }
  if (!evidence.log.empty()) {
    EvaluateLog(evidence.log, record.limits, track ? &*track : nullptr, evaluation);
  }
  return evaluation;
}

}  // namespace twin::application

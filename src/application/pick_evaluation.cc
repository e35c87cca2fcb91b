#include "application/pick_evaluation.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Core>

#include "application/pick_figures.h"
#include "twin/model/rotation.h"
#include "twin/model/transform.h"

namespace twin::application {
namespace {

using plant::ObjectTrack;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMostDistance = 5e-3;      // m, from the goal
constexpr double kMostAngle = 3 * kDegree;  // rad
constexpr double kStillSpeed = 1e-3;        // m/s
constexpr double kStillTurnRate = kDegree;  // rad/s
/// A fall of 2 mm takes as long.
constexpr Duration kLongestFall = std::chrono::milliseconds(20);

double Distance(const Transform& a, const Transform& b) {
  return (model::Position(a) - model::Position(b)).norm();
}

double Angle(const Transform& a, const Transform& b) {
  return model::TurnBetween(a, b).norm();
}

/// Collects findings.
class Findings {
 public:
  void Tell(std::string quantity, double value, std::string unit = "") {
    all.push_back({.quantity = std::move(quantity), .value = value, .unit = std::move(unit)});
  }
  void Demand(std::string quantity, double value, std::string unit, double most) {
    const bool met = value <= most;
    all.push_back({.quantity = std::move(quantity),
                   .value = value,
                   .unit = std::move(unit),
                   .demand = most == 0 ? "none" : fmt::format("at most {:g}", most),
                   .met = met});
    if (!all.back().unit.empty() && most != 0) all.back().demand += " " + all.back().unit;
  }

  std::vector<Finding> all;
};

/// The longest time in which the object was borne neither by what is around it nor by both fingers.
Duration LongestFall(const ObjectTrack& track) {
  Duration longest{};
  for (std::size_t i = 0; i < track.changes.size(); ++i) {
    const plant::Support& now = track.changes[i].now;
    // Before the first step it stands exactly on its place, which is no contact yet.
    if (i == 0 || now.world || now.between_fingers()) continue;
    const Time end = i + 1 < track.changes.size() ? track.changes[i + 1].at : track.last.at;
    longest = std::max(longest, end - track.changes[i].at);
  }
  return longest;
}

/// When the object was in the fingers alone: from the last time it left its place until it first
/// came to rest on another.
struct Carried {
  Time begin{};
  Time end{};
};

std::optional<Carried> WhenCarried(const ObjectTrack& track) {
  std::optional<Carried> carried;
  for (std::size_t i = 0; i + 1 < track.changes.size(); ++i) {
    const plant::Support& now = track.changes[i].now;
    if (now.world || !now.between_fingers()) continue;
    const Time end = track.changes[i + 1].at;
    if (!carried || end - track.changes[i].at > carried->end - carried->begin) {
      carried = Carried{track.changes[i].at, end};
    }
  }
  return carried;
}

/// How far the object moved in the hand while it was carried.
void TellSlip(const ObjectTrack& track, Findings& findings) {
  const auto carried = WhenCarried(track);
  if (!carried) return;
  std::optional<Transform> first;
  double distance = 0;
  double angle = 0;
  for (const plant::ObjectSample& sample : track.samples) {
    if (sample.at < carried->begin || sample.at > carried->end) continue;
    if (!first) first = sample.X_HB;
    distance = std::max(distance, Distance(*first, sample.X_HB));
    angle = std::max(angle, Angle(*first, sample.X_HB));
  }
  findings.Tell("slip of the object in the hand, largest", distance * 1e3, "mm");
  findings.Tell("rotation of the object in the hand, largest", angle / kDegree, "deg");
}

/// How far the closing fingers moved the object.
void TellPush(const ObjectTrack& track, const PickTask& task, Findings& findings) {
  const auto carried = WhenCarried(track);
  if (!carried) return;
  Transform last = task.object.X_WB;
  for (const plant::ObjectSample& sample : track.samples) {
    if (sample.at <= carried->begin) last = sample.X_WB;
  }
  findings.Tell("displacement of the object by the grasp", Distance(task.object.X_WB, last) * 1e3,
                "mm");
}

std::vector<std::string> UnwantedContacts(const PickTask& task, const plant::ContactWatch& contacts,
                                          const ObjectTrack& track) {
  std::vector<std::string> unwanted;
  for (const plant::ContactPair& pair : contacts.Pairs()) {
    const bool is_finger = pair.a == "panda_leftfinger" || pair.a == "panda_rightfinger";
    if (is_finger && pair.b == task.object.name) continue;
    unwanted.push_back(fmt::format("{} and {}", pair.a, pair.b));
  }
  for (const plant::ObjectContact& contact : track.touched) {
    if (contact.part == task.from || contact.part == task.to) continue;
    unwanted.push_back(fmt::format("{} and {}", track.body, contact.part));
  }
  return unwanted;
}

/// What really became of the object.
void EvaluateTruth(const PickTask& task, const plant::ContactWatch& contacts,
                   const ObjectTrack& track, Findings& findings) {
  const plant::ObjectSample& end = track.last;
  findings.Demand("object position error", Distance(end.X_WB, task.O_T_goal) * 1e3, "mm",
                  kMostDistance * 1e3);
  findings.Demand("object orientation error", Angle(end.X_WB, task.O_T_goal) / kDegree, "deg",
                  kMostAngle / kDegree);
  findings.Demand("object speed at the end", end.speed * 1e3, "mm/s", kStillSpeed * 1e3);
  findings.Demand("object turn rate at the end", end.turn_rate / kDegree, "deg/s",
                  kStillTurnRate / kDegree);
  findings.Demand("longest free fall of the object", ToSeconds(LongestFall(track)) * 1e3, "ms",
                  ToSeconds(kLongestFall) * 1e3);
  const std::vector<std::string> unwanted = UnwantedContacts(task, contacts, track);
  findings.Demand(unwanted.empty()
                      ? "unwanted contacts"
                      : fmt::format("unwanted contacts: {}", fmt::join(unwanted, "; ")),
                  static_cast<double>(unwanted.size()), "", 0);
  TellPush(track, task, findings);
  TellSlip(track, findings);
}

/// Nothing where nobody simulates it.
std::optional<ObjectTrack> TrackOf(const std::string& object, const Evidence& evidence) {
  if (evidence.contacts == nullptr) return std::nullopt;
  std::vector<ObjectTrack> tracks = evidence.contacts->objects().Tracks();
  const auto track = std::ranges::find(tracks, object, &ObjectTrack::body);
  if (track == tracks.end()) return std::nullopt;
  return std::move(*track);
}

void DemandLimits(const PickTrace& trace, Findings& findings) {
  if (trace.t.empty()) return;
  findings.Demand("peak joint velocity of the reference / limit",
                  std::ranges::max(trace.velocity) * 1e2, "%", 100);
  findings.Demand("peak joint acceleration of the reference / limit",
                  std::ranges::max(trace.acceleration) * 1e2, "%", 100);
  findings.Demand("peak joint jerk of the reference / limit", std::ranges::max(trace.jerk) * 1e2,
                  "%", 100);
}

/// What the robot knows of it. @param is_all  whether nothing else is known.
void EvaluateReports(const PickRecord& record, bool is_all, Findings& findings) {
  if (!record.is_placed) return;
  const Transform O_T_object = model::Multiply(record.O_T_EE_placed, model::Inverse(record.B_T_EE));
  const double distance = Distance(O_T_object, record.task.O_T_goal) * 1e3;
  const double angle = Angle(O_T_object, record.task.O_T_goal) / kDegree;
  const char* quantity = "position error at release, by the robot's joints";
  const char* turned = "orientation error at release, by the robot's joints";
  if (is_all) {
    findings.Demand(quantity, distance, "mm", kMostDistance * 1e3);
    findings.Demand(turned, angle, "deg", kMostAngle / kDegree);
  } else {
    findings.Tell(quantity, distance, "mm");
    findings.Tell(turned, angle, "deg");
  }
  findings.Tell("finger width after the grasp", record.width_grasped * 1e3, "mm");
  findings.Tell("finger width before the release", record.width_placed * 1e3, "mm");
}

}  // namespace

Evaluation EvaluatePick(const PickRecord& record, const TaskResult& task_result,
                        const Evidence& evidence) {
  Findings findings;
  findings.Demand(record.robot_errors.empty() ? "errors of the robot"
                                              : fmt::format("errors of the robot: {}",
                                                            fmt::join(record.robot_errors, "; ")),
                  static_cast<double>(record.robot_errors.size()), "", 0);
  const std::optional<ObjectTrack> track = TrackOf(record.task.object.name, evidence);
  if (track) EvaluateTruth(record.task, *evidence.contacts, *track, findings);
  EvaluateReports(record, !track, findings);
  const auto failed = std::ranges::count(task_result.task.steps, false, &StepReport::succeeded);
  findings.Tell("repeated or failed attempts", static_cast<double>(failed));
  findings.Tell("planned duration of all motions", ToSeconds(record.moved), "s");
  if (evidence.session.counts.cycles() > 0) {
    findings.Tell("unserved cycles", evidence.session.counts.unserved_percent(), "%");
  }
  Evaluation evaluation;
  if (!evidence.log.empty()) {
    const PickTrace trace = ReadPickTrace(evidence.log, record.limits);
    DemandLimits(trace, findings);
    evaluation.figures = PickFigures(trace, track ? &*track : nullptr);
  }
  evaluation.findings = std::move(findings.all);
  return evaluation;
}

}  // namespace twin::application

#include "twin/application/application.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "application/applications.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/render/renderer.h"

namespace twin::application {
namespace {

struct Entry {
  std::string_view name;
  std::unique_ptr<Application> (*make)(control::ParameterReader& parameters);
};

constexpr std::array<Entry, 4> kApplications{{
    {"compliance", MakeCompliance},
    {"pick_and_place", MakePickAndPlace},
    {"plan_and_execute", MakePlanAndExecute},
    {"teleoperation", MakeTeleoperation},
}};

/// "<file>:<line>: " when the name was read from there.
std::string PlaceOf(const scenario::Scenario& scenario) {
  const scenario::Place& place = scenario.places.application;
  return place.name == scenario.application->type && !place.where.empty() ? place.where + ": " : "";
}

const scenario::Scenario& WithApplication(const scenario::Scenario& scenario) {
  scenario.Validate();
  if (!scenario.application) {
    throw InputError("application: the scenario has a motion, and no application");
  }
  return scenario;
}

double DistanceBetween(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

}  // namespace

std::unique_ptr<Application> Make(const scenario::Scenario& scenario) {
  const scenario::ApplicationSection& wanted = scenario.application.value();
  const auto* entry = std::ranges::find(kApplications, wanted.type, &Entry::name);
  if (entry == kApplications.end()) {
    std::vector<std::string_view> names;
    for (const Entry& each : kApplications) names.push_back(each.name);
    throw InputError(fmt::format("{}application \"{}\" is unknown; there are: {}",
                                 PlaceOf(scenario), wanted.type, fmt::join(names, ", ")));
  }
  control::ParameterReader reader(wanted.parameters, "application.parameters");
  std::unique_ptr<Application> application = entry->make(reader);
  reader.RefuseUnread();
  if (scenario.base && !application->drives_base()) {
    throw InputError(
        fmt::format("{}application {}: it takes the arm to stand on the world; leave base out",
                    PlaceOf(scenario), wanted.type));
  }
  application->Require(scenario);
  return application;
}

std::optional<plant::ObjectTrack> Evidence::TrackOf(std::string_view body) const {
  if (contacts == nullptr) return std::nullopt;
  std::vector<plant::ObjectTrack> tracks = contacts->objects().Tracks();
  const auto track = std::ranges::find(tracks, body, &plant::ObjectTrack::body);
  if (track == tracks.end()) return std::nullopt;
  return std::move(*track);
}

void Evaluation::Report(std::string quantity, double value, std::string unit) {
  findings.push_back({.quantity = std::move(quantity), .value = value, .unit = std::move(unit)});
}

void Evaluation::Demand(std::string quantity, double value, std::string unit, std::string demand,
                        bool met) {
  Report(std::move(quantity), value, std::move(unit));
  findings.back().demand = std::move(demand);
  findings.back().met = met;
}

void Evaluation::DemandAtMost(std::string quantity, double value, std::string unit, double most) {
  std::string demand =
      most == 0 ? "none" : fmt::format("at most {:g}{}{}", most, unit.empty() ? "" : " ", unit);
  Demand(std::move(quantity), value, std::move(unit), std::move(demand), value <= most);
}

void Evaluation::DemandNone(std::string quantity, const std::vector<std::string>& list) {
  if (!list.empty()) quantity += fmt::format(": {}", fmt::join(list, "; "));
  DemandAtMost(std::move(quantity), static_cast<double>(list.size()), "", 0);
}

bool Succeeded(const TaskResult& task_result, const Evaluation& evaluation) noexcept {
  return task_result.task.failure.empty() &&
         std::ranges::none_of(evaluation.findings,
                              [](const Finding& finding) { return finding.met == false; });
}

std::string FailureOf(const TaskResult& task_result, const Evaluation& evaluation) {
  if (!task_result.task.failure.empty()) return task_result.task.failure;
  for (const Finding& finding : evaluation.findings) {
    if (finding.met != false) continue;
    return fmt::format("{} is {:.4g}{}{}; demanded: {}", finding.quantity, finding.value,
                       finding.unit.empty() ? "" : " ", finding.unit, finding.demand);
  }
  return {};
}

Transform Stage::F_T_EE() const {
  return session.robot().F_T_EE(scenario.onboard.NE_T_EE);
}

std::unique_ptr<planning::CollisionWorld> Stage::MakeWorld() const {
  return std::make_unique<planning::CollisionWorld>(
      run::MakeRobotConfig(scenario, session.robot(), files).plant);
}

TaskReport Stage::Carry(const std::vector<TaskStep>& steps) const {
  const auto on_attempt = [this](const StepReport& step) {
    const std::string line =
        fmt::format("{}: {}{}{}", step.name, step.succeeded ? "done" : "failed",
                    step.text.empty() ? "" : ", ", step.text);
    session.Tell("step", line);
    if (tell) tell(fmt::format("{:8.3f} s  {}", ToSeconds(step.ended.time_since_epoch()), line));
  };
  return application::Carry(
      steps, [this] { return session.Now(); }, on_attempt,
      [this] { return session.interrupted(); });
}

std::vector<Vector3> Thinned(const std::vector<Vector3>& points) {
  constexpr double kApart = 0.02;  // m
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    length += DistanceBetween(points[i], points[i - 1]);
  const double apart =
      std::max(kApart, length / static_cast<double>(render::Ghost::kMostPoints - 2));
  std::vector<Vector3> path{points.front()};
  for (const Vector3& point : points) {
    if (DistanceBetween(point, path.back()) >= apart) path.push_back(point);
  }
  return path;
}

std::vector<Vector3> EndEffectorPath(const reference::Trajectory& trajectory,
                                     const Transform& F_T_EE) {
  constexpr Duration kStep = std::chrono::milliseconds(5);
  std::vector<Vector3> all;
  for (Duration t{}; t < trajectory.duration() + kStep; t += kStep) {
    const Transform O_T_EE =
        model::ArmModel::Panda().Pose(model::Frame::kEndEffector, trajectory.Sample(t).q, F_T_EE);
    all.push_back({O_T_EE[12], O_T_EE[13], O_T_EE[14]});
  }
  return Thinned(all);
}

ApplicationRun::ApplicationRun(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                               const run::RunFiles& files, record::RecordSink* sink,
                               const Clock& clock, const run::RealtimeSettings& settings)
    : scenario_(WithApplication(scenario)),
      files_(files),
      clock_(clock),
      devices_(catalogue.devices),
      application_(Make(scenario_)),
      session_(scenario_, catalogue, files_, sink, settings) {}

bool ApplicationRun::CheckStart(const run::TellCheck& tell) {
  const reference::Trajectory standing =
      run::StandingFor(scenario_.robot.q_start.value(), std::chrono::seconds(1), robot().limits);
  return session_.CheckStart(
      run::MotionOn(scenario_, "start", application_->first_interface(), standing), tell);
}

const TaskResult& ApplicationRun::Execute(const run::RunHooks& hooks,
                                          const std::function<void(std::string_view)>& tell) {
  session_.Begin(hooks);
  try {
    Stage stage{session_, scenario_, files_, clock_, devices_, tell};
    task_result_ = application_->Perform(stage);
  } catch (...) {
    result_ = session_.End();
    throw;
  }
  result_ = session_.End();
  return task_result_;
}

Evaluation ApplicationRun::Evaluate(Evidence evidence) {
  evidence.session = result_;
  return application_->Evaluate(task_result_, evidence);
}

}  // namespace twin::application

#include "twin/application/application.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <exception>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "application/applications.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/model/arm_model.h"
#include "twin/render/renderer.h"
#include "twin/run/islands.h"
#include "twin/run/robot_config.h"

namespace twin::application {
namespace {

struct Entry {
  std::string_view name;
  std::unique_ptr<Application> (*make)(control::ParameterReader& parameters);
  /// Of the first motion: the robot must grant it before anything moves.
  control::CommandInterface first_interface = control::CommandInterface::kTorque;
  bool drives_base = false;      ///< supports a mobile base, where O moves
  bool stands_anywhere = false;  ///< minds robot.pose
};

constexpr std::array<Entry, 5> kApplications{{
    {.name = "compliance", .make = MakeCompliance},
    {.name = "hand_over",
     .make = MakeHandOver,
     .first_interface = control::CommandInterface::kJointPosition,
     .stands_anywhere = true},
    {.name = "pick_and_place",
     .make = MakePickAndPlace,
     .first_interface = control::CommandInterface::kJointPosition,
     .stands_anywhere = true},
    {.name = "plan_and_execute", .make = MakePlanAndExecute},
    {.name = "teleoperation",
     .make = MakeTeleoperation,
     .drives_base = true,
     .stands_anywhere = true},
}};

/// "<file>:<line>: " when the name was read from there.
std::string PlaceOf(const scenario::Scenario& scenario) {
  const scenario::Place& place = scenario.places.application;
  return place.name == scenario.application->type && !place.where.empty() ? place.where + ": " : "";
}

/// @throws InputError naming the known applications.
const Entry& EntryOf(const scenario::Scenario& scenario) {
  const std::string& type = scenario.application.value().type;
  const auto* entry = std::ranges::find(kApplications, type, &Entry::name);
  if (entry != kApplications.end()) return *entry;
  std::vector<std::string_view> names(kApplications.size());
  std::ranges::transform(kApplications, names.begin(), &Entry::name);
  throw InputError(fmt::format("{}application \"{}\" is unknown; there are: {}", PlaceOf(scenario),
                               type, fmt::join(names, ", ")));
}

const scenario::Scenario& WithApplication(const scenario::Scenario& scenario) {
  scenario.Validate();
  if (!scenario.application) {
    throw InputError("application: the scenario has a motion, and no application");
  }
  return scenario;
}

/// Index of a step among the first `count`; `count`: none of them.
std::size_t IndexOf(const std::vector<TaskStep>& steps, const std::string& name,
                    std::size_t count) {
  const auto some = std::span(steps).first(count);
  return static_cast<std::size_t>(std::ranges::find(some, name, &TaskStep::name) - some.begin());
}

void RequireValid(const std::vector<TaskStep>& steps) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const TaskStep& step = steps[i];
    if (step.attempts < 1) {
      throw InputError(
          fmt::format("step {}: {} attempts; it takes at least 1", step.name, step.attempts));
    }
    if (IndexOf(steps, step.name, i) < i) {
      throw InputError(fmt::format("step {} stands twice in a task", step.name));
    }
    if (step.after_failure.empty() || IndexOf(steps, step.after_failure, i + 1) <= i) continue;
    throw InputError(
        fmt::format("step {}: after a failure it goes on at {}, which is no step at or before it",
                    step.name, step.after_failure));
  }
}

/// Least difference that means something in a finding, as a number of decimals.
constexpr std::array<std::pair<std::string_view, int>, 14> kDecimals{{{"mm", 3},
                                                                      {"mm/s", 2},
                                                                      {"deg", 3},
                                                                      {"deg/s", 2},
                                                                      {"mrad", 2},
                                                                      {"rad", 4},
                                                                      {"m/s", 3},
                                                                      {"m/s^3", 2},
                                                                      {"s", 2},
                                                                      {"ms", 1},
                                                                      {"%", 2},
                                                                      {"N", 1},
                                                                      {"Nm", 2},
                                                                      {"mJ", 2}}};

/// One attempt. @param is_lost  set when the step threw RobotFault.
StepEnd Try(const TaskStep& step, bool& is_lost) {
  try {
    return step.act();
  } catch (const RobotFault& fault) {
    is_lost = true;
    return {false, fault.what()};
  }
}

}  // namespace

std::string RoundedText(double value, std::string_view unit) {
  constexpr int kDigits = 4;
  const auto* const known =
      std::ranges::find(kDecimals, unit, &std::pair<std::string_view, int>::first);
  if (known == kDecimals.end() || !std::isfinite(value)) return fmt::format("{:.4g}", value);
  const double size = std::abs(value);
  const int before = size < 1 ? 1 : static_cast<int>(std::floor(std::log10(size))) + 1;
  std::string text = fmt::format("{:.{}f}", value, std::clamp(kDigits - before, 0, known->second));
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  return is_zero && text.starts_with('-') ? text.substr(1) : text;
}

std::string VerdictOf(const Evaluation& evaluation) {
  constexpr std::size_t kMost = 4;
  std::vector<std::string> met;
  std::vector<std::string> missed;
  for (const Finding& finding : evaluation.findings) {
    if (!finding.met) continue;
    const std::string unit = finding.unit.empty() ? "" : " " + finding.unit;
    (*finding.met ? met : missed)
        .push_back(fmt::format("{} {}{} (demanded: {})", finding.quantity,
                               RoundedText(finding.value, finding.unit), unit, finding.demand));
  }
  if (met.empty() && missed.empty()) return "";
  const std::size_t count = met.size() + missed.size();
  std::vector<std::string>& told = missed.empty() ? met : missed;
  const bool is_cut = told.size() > kMost;
  if (is_cut) told.resize(kMost);
  const std::string head = !missed.empty()
                               ? fmt::format("{} of {} demands missed", count - met.size(), count)
                           : count == 1 ? "The one demand is met"
                                        : fmt::format("All {} demands are met", count);
  return fmt::format("{}: {}{}.", head, fmt::join(told, "; "),
                     is_cut ? "; and so on, see the results" : "");
}

std::unique_ptr<Application> Make(const scenario::Scenario& scenario, const Partners* partners) {
  const Entry& entry = EntryOf(scenario);
  control::ParameterReader reader(scenario.application->parameters, "application.parameters");
  std::unique_ptr<Application> application = entry.make(reader);
  reader.RefuseUnread();
  if (scenario.base && !entry.drives_base) {
    throw InputError(
        fmt::format("{}application {}: it takes the arm to stand on the world; leave base out",
                    PlaceOf(scenario), entry.name));
  }
  if (!entry.stands_anywhere && !(scenario.robot.pose == plant::ArmPose())) {
    throw InputError(fmt::format(
        "{}robot.pose: the application {} takes the arm to stand at the world's origin; leave it "
        "out",
        PlaceOf(scenario), entry.name));
  }
  application->Require(scenario);
  application->RequirePartners(scenario, partners);
  return application;
}

TaskReport Carry(const std::vector<TaskStep>& steps, const std::function<Time()>& now,
                 const std::function<void(const StepReport&)>& on_attempt,
                 const std::function<bool()>& interrupted) {
  RequireValid(steps);
  std::vector<int> failures(steps.size(), 0);
  TaskReport report;
  for (std::size_t i = 0; i < steps.size();) {
    const TaskStep& step = steps[i];
    if (interrupted && interrupted()) {
      report.failure = fmt::format("interrupted before step {}", step.name);
      return report;
    }
    StepReport attempt{.name = step.name, .attempt = failures[i] + 1, .begun = now()};
    bool is_lost = false;
    StepEnd end = Try(step, is_lost);
    attempt.ended = now();
    attempt.succeeded = end.succeeded;
    attempt.text = std::move(end.text);
    report.steps.push_back(attempt);
    if (on_attempt) on_attempt(attempt);
    if (attempt.succeeded) {
      ++i;
      continue;
    }
    ++failures[i];
    if (is_lost || failures[i] >= step.attempts || step.after_failure.empty()) {
      report.failure = fmt::format("step {} failed: {}", step.name, attempt.text);
      if (failures[i] > 1) report.failure += fmt::format(" (attempt {})", failures[i]);
      return report;
    }
    i = IndexOf(steps, step.after_failure, i + 1);
  }
  return report;
}

std::optional<plant::ObjectTrack> Evidence::TrackOf(std::string_view body) const {
  if (contacts == nullptr) return std::nullopt;
  std::vector<plant::ObjectTrack> tracks = contacts->objects().Tracks();
  const auto track = std::ranges::find(tracks, body, &plant::ObjectTrack::body);
  if (track == tracks.end()) return std::nullopt;
  return std::move(*track);
}

void Evaluation::Add(std::string quantity, double value, std::string unit) {
  findings.push_back({.quantity = std::move(quantity), .value = value, .unit = std::move(unit)});
}

void Evaluation::Demand(std::string quantity, double value, std::string unit, std::string demand,
                        bool met) {
  Add(std::move(quantity), value, std::move(unit));
  findings.back().demand = std::move(demand);
  findings.back().met = met;
}

void Evaluation::DemandAtMost(std::string quantity, double value, std::string unit,
                              std::optional<double> most) {
  if (!most) return Add(std::move(quantity), value, std::move(unit));
  std::string demand =
      *most == 0 ? "none" : fmt::format("at most {:g}{}{}", *most, unit.empty() ? "" : " ", unit);
  Demand(std::move(quantity), value, std::move(unit), std::move(demand), value <= *most);
}

void Evaluation::DemandNone(std::string quantity, const std::vector<std::string>& list) {
  if (!list.empty()) quantity += fmt::format(": {}", fmt::join(list, "; "));
  DemandAtMost(std::move(quantity), static_cast<double>(list.size()), "", 0);
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
  return run::MakeWorld(scenario, session.robot(), files);
}

void Stage::Carry(const std::vector<TaskStep>& steps) {
  const auto on_attempt = [this](const StepReport& step) {
    const std::string line =
        fmt::format("{}: {}{}{}", step.name, step.succeeded ? "done" : "failed",
                    step.text.empty() ? "" : ", ", step.text);
    session.Tell("step", line);
    if (tell) tell(fmt::format("{:8.3f} s  {}", ToSeconds(step.ended.time_since_epoch()), line));
  };
  result.task = application::Carry(
      steps, [this] { return session.Now(); }, on_attempt,
      [this] { return session.interrupted(); });
}

run::MotionResult Stage::Move(const run::Motion& motion) {
  run::MotionResult moved = session.Move(motion);
  if (moved.report.errors.any()) result.robot_errors.push_back(moved.report.failure);
  return moved;
}

std::vector<Vector3> EndEffectorPath(const std::vector<JointVector>& q, const Transform& F_T_EE) {
  static_assert(render::Ghost::kMostPoints <= record::PlanRecord::kMostPoints);
  constexpr double kApart = 0.02;  // m
  const auto distance = [](const Vector3& a, const Vector3& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  };
  std::vector<Vector3> points;
  double length = 0;
  for (const JointVector& at : q) {
    const Transform O_T_EE = model::ArmModel::Panda().Pose(model::Frame::kEndEffector, at, F_T_EE);
    points.push_back({O_T_EE[12], O_T_EE[13], O_T_EE[14]});
    if (points.size() > 1) length += distance(points.back(), points[points.size() - 2]);
  }
  const double apart =
      std::max(kApart, length / static_cast<double>(render::Ghost::kMostPoints - 2));
  std::vector<Vector3> path{points.front()};
  for (const Vector3& point : points) {
    if (distance(point, path.back()) >= apart) path.push_back(point);
  }
  return path;
}

std::vector<Vector3> EndEffectorPath(const reference::Trajectory& trajectory,
                                     const Transform& F_T_EE) {
  constexpr Duration kStep = std::chrono::milliseconds(5);
  std::vector<JointVector> q;
  for (Duration t{}; t < trajectory.duration() + kStep; t += kStep) {
    q.push_back(trajectory.Sample(t).q);
  }
  return EndEffectorPath(q, F_T_EE);
}

ApplicationRun::ApplicationRun(const scenario::Scenario& scenario, const run::Catalogue& catalogue,
                               const run::RunFiles& files, record::RecordSink* sink,
                               const Clock& clock, const run::RealtimeConfig& settings,
                               const Partners* partners)
    : scenario_(WithApplication(scenario)),
      files_(files),
      application_(Make(scenario_, partners)),
      session_(scenario_, catalogue, files_, sink, settings),
      stage_{session_, scenario_, files_, clock, catalogue.devices, partners} {}

bool ApplicationRun::CheckStart(const run::TellCheck& tell) {
  const reference::Trajectory standing =
      run::StandingFor(scenario_.robot.q_start.value(), std::chrono::seconds(1), robot().limits);
  return session_.CheckStart(
      run::MotionOn(scenario_, "start", EntryOf(scenario_).first_interface, standing), tell);
}

const TaskResult& ApplicationRun::Execute(const run::RunHooks& hooks,
                                          const std::function<void(std::string_view)>& tell) {
  stage_.tell = tell;
  session_.Begin(hooks);
  // Another robot may wait for this one, and the session of several ends with the last of them.
  const auto tell_end = [this](const std::string& failure) {
    if (stage_.partners == nullptr) return;
    stage_.partners->board().End(stage_.partners->own(), failure);
  };
  try {
    application_->Perform(stage_);
  } catch (const std::exception& error) {
    tell_end(error.what());
    session_.End();
    throw;
  }
  tell_end(stage_.result.task.failure);
  result_ = session_.End();
  return stage_.result;
}

const Evaluation& ApplicationRun::Evaluate(Evidence evidence) {
  evidence.session = result_;
  if (const plant::TruthProbe* truth = session_.connection().truth) {
    evidence.prefix = truth->prefix();
  }
  evaluation_ = application_->Evaluate(stage_.result, evidence);
  return evaluation_;
}

}  // namespace twin::application

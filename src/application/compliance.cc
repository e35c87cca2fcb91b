#include "application/compliance.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "application/applications.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"

namespace twin::application {
namespace compliance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Duration of the motion back.
constexpr Duration kBack = seconds(2);
/// Largest joint position in q0, rad, as in the controller.
constexpr double kFarthest = 10;

/// Reads two parameters of three axes each. The ranges are the controller's.
Vector6 ReadAxes(control::ParameterReader& p, const std::string& key, Dimension translation,
                 Dimension rotation, const Vector6& otherwise, double most_along,
                 double most_about) {
  const Vector3 along = p.Vector(key + ".translation", translation,
                                 {otherwise[0], otherwise[1], otherwise[2]}, 0, most_along);
  const Vector3 about = p.Vector(key + ".rotation", rotation,
                                 {otherwise[3], otherwise[4], otherwise[5]}, 0, most_about);
  return {along[0], along[1], along[2], about[0], about[1], about[2]};
}

void ReadGains(control::ParameterReader& p, const std::string& key, Gains& gains) {
  gains.K_P = ReadAxes(p, key + ".stiffness", Dimension::kLinearStiffness, Dimension::kStiffness,
                       gains.K_P, 5000, 500);
  gains.K_D = ReadAxes(p, key + ".damping", Dimension::kLinearDamping, Dimension::kAngularDamping,
                       gains.K_D, 1000, 100);
}

/// Adds a list of numbers with their unit.
void AddNumbers(std::string key, std::span<const double> values, std::string_view unit,
                control::Parameters& parameters) {
  std::vector<std::string>& texts =
      parameters
          .emplace_back(control::Parameter{.key = std::move(key), .values = {}, .is_list = true})
          .values;
  for (const double value : values) texts.push_back(FormatNumber(value).append(unit));
}

/// The gains as parameters of the controller.
control::Parameters ParametersOf(const Gains& gains, const JointVector& q_0, const Config& config,
                                 const char* reference) {
  control::Parameters parameters{
      {.key = "reference", .values = {reference}},
      {.key = "k0", .values = {FormatNumber(config.k_0) + " Nm/rad"}},
      {.key = "q0.unit", .values = {"rad"}},
      {.key = "soft_start", .values = {FormatDuration(config.soft_start)}}};
  AddNumbers("stiffness.translation", std::span(gains.K_P).first(3), " N/m", parameters);
  AddNumbers("stiffness.rotation", std::span(gains.K_P).last(3), " Nm/rad", parameters);
  AddNumbers("damping.translation", std::span(gains.K_D).first(3), " Ns/m", parameters);
  AddNumbers("damping.rotation", std::span(gains.K_D).last(3), " Nms/rad", parameters);
  AddNumbers("q0.values", q_0, "", parameters);
  if (config.friction_compensation) {
    parameters.push_back(
        {.key = "friction_compensation", .values = {FormatNumber(*config.friction_compensation)}});
  }
  return parameters;
}

reference::PoseTrajectory PathFrom(const Transform& O_T_EE, const Config& config,
                                   const CartesianLimits& limits) {
  const auto moved = [](Transform pose, const Vector3& by) {
    for (std::size_t i = 0; i < by.size(); ++i) pose[12 + i] += by[i];
    return pose;
  };
  const Transform first = moved(O_T_EE, config.first);
  return reference::PoseTrajectory({{.O_T_EE = O_T_EE, .at = Duration::zero()},
                                    {.O_T_EE = first, .at = config.leg},
                                    {.O_T_EE = moved(first, config.second), .at = 2 * config.leg},
                                    {.O_T_EE = O_T_EE, .at = 3 * config.leg},
                                    {.O_T_EE = O_T_EE, .at = 3 * config.leg + config.rest}},
                                   {}, limits);
}

/// @throws InputError naming place, key, value and range.
Config ReadConfig(control::ParameterReader& p) {
  Config s;
  ReadGains(p, "stiff", s.stiff);
  ReadGains(p, "compliant", s.compliant);
  s.k_0 = p.Quantity("k0", Dimension::kStiffness, s.k_0, 0, 100);
  s.q_0 = p.Joints("q0", Dimension::kAngle, s.q_0, -kFarthest, kFarthest);
  if (p.Has("friction_compensation")) {
    s.friction_compensation = p.Number("friction_compensation", 0, 0, 1);
  }
  s.soft_start = p.Time("soft_start", s.soft_start, Duration::zero(), seconds(10));
  s.standing = p.Time("standstill.duration", s.standing, seconds(1), seconds(600));
  s.first = p.Vector("trajectory.first", Dimension::kLength, s.first, -1, 1);
  s.second = p.Vector("trajectory.second", Dimension::kLength, s.second, -1, 1);
  s.leg = p.Time("trajectory.leg", s.leg, milliseconds(100), seconds(600));
  s.rest = p.Time("trajectory.rest", s.rest, milliseconds(100), seconds(600));
  s.elsewhere = p.Joints("null_space.q0", Dimension::kAngle, s.elsewhere, -kFarthest, kFarthest);
  s.wandering = p.Time("null_space.duration", s.wandering, seconds(1), seconds(600));
  if (s.wandering < s.soft_start + 2 * kSteady) {
    p.Refuse("null_space.duration",
             fmt::format("{} is too short; it must be at least {}, {} after the soft start",
                         FormatDuration(s.wandering), FormatDuration(s.soft_start + 2 * kSteady),
                         FormatDuration(2 * kSteady)));
  }
  return s;
}

/// Planned duration of a case's motion, without the controller's settling.
Duration LengthOf(const Case& one, const Config& config) noexcept {
  if (one.kind == Kind::kTrajectory) return 3 * config.leg + config.rest;
  return one.kind == Kind::kStandstill ? config.standing : config.wandering;
}

/// The motion of a case, from the robot's present position.
/// @throws InputError if its path violates a limit of the end effector's motion.
run::Motion MotionOf(const Case& one, const Config& config, const Stage& stage,
                     const RobotState& state) {
  const bool moves = one.kind == Kind::kTrajectory;
  run::Motion motion = run::MotionOn(
      stage.scenario, fmt::format("{}: {}", one.id, one.what), control::CommandInterface::kTorque,
      run::StandingFor(state.q, LengthOf(one, config), stage.session.robot().limits));
  if (moves) motion.poses = PathFrom(state.O_T_EE, config, stage.session.robot().cartesian);
  motion.controller.type = "compliance";
  motion.controller.parameters = ParametersOf(
      GainsOf(one, config), one.kind == Kind::kNullSpace ? config.elsewhere : config.q_0, config,
      moves ? "path" : "hold");
  return motion;
}

/// The motion back to robot.q_start, also on the torque interface.
run::Motion MotionBack(const Case& from, const Stage& stage) {
  return run::MotionOn(
      stage.scenario, fmt::format("back from {}", from.id), control::CommandInterface::kTorque,
      reference::Trajectory({{.q = stage.session.ReadState().q, .at = Duration::zero()},
                             {.q = stage.scenario.robot.q_start.value(), .at = kBack}},
                            {}, stage.session.robot().limits));
}

void RequireMeasurable(const Case& one, const plant::Push& push, const Config& config) {
  const auto fail = [&one](const std::string& why) {
    throw InputError(fmt::format("perturbations: the push of case {}: {}", one.id, why));
  };
  if (push.frame != plant::ForceFrame::kWorld || push.force == Vector3{} ||
      push.torque != Vector3{}) {
    fail("it must be a force and no torque, in the world's axes");
  }
  if (push.begin < config.soft_start + kBefore) {
    fail(fmt::format("begin is {}; it must be at least {}, {} after the soft start",
                     FormatDuration(push.begin), FormatDuration(config.soft_start + kBefore),
                     FormatDuration(kBefore)));
  }
  if (push.duration - 2 * push.rise < 2 * kSteady) {
    fail(fmt::format("the force is constant for {}; it must be for at least {}, to settle",
                     FormatDuration(push.duration - 2 * push.rise), FormatDuration(2 * kSteady)));
  }
  if (push.begin + push.duration >= LengthOf(one, config)) {
    fail(fmt::format("it ends {} after the motion's begin; the motion takes {}",
                     FormatDuration(push.begin + push.duration),
                     FormatDuration(LengthOf(one, config))));
  }
}

/// The scenario's pushes.
/// @throws InputError if a pushed case has no push or several, another motion has a push, A's
/// differs from B's or C's from D's, or the deflection of a push cannot be measured.
Pushes PushesOf(const scenario::Scenario& scenario, const Config& config) {
  Pushes pushes;
  for (const plant::Perturbation& perturbation : scenario.perturbations) {
    const auto* push = std::get_if<plant::Push>(&perturbation);
    const auto one = std::ranges::find_if(kAllCases, [push](const Case& each) {
      return push != nullptr && each.is_pushed && push->motion == each.motion;
    });
    if (one == kAllCases.end()) {
      throw InputError(
          "perturbations: one is no push in a case that is pushed, motion: 1 (A), 3 (B), 7 (C) or "
          "11 (D); leave it out");
    }
    std::optional<plant::Push>& place =
        pushes.at(static_cast<std::size_t>(one - kAllCases.begin()));
    if (place) {
      throw InputError(fmt::format("perturbations: case {} has two pushes (motion: {}); it needs 1",
                                   one->id, one->motion));
    }
    place = *push;
  }
  for (std::size_t i = 0; i < kCases; ++i) {
    const Case& one = kAllCases[i];
    if (!one.is_pushed || pushes[i]) continue;
    throw InputError(
        fmt::format("perturbations: case {} ({}) has no push; it needs one: {{..., motion: {}}}",
                    one.id, one.what, one.motion));
  }
  for (const auto& [i, j] : {std::pair(kA, kB), {kC, kD}}) {
    plant::Push push = *pushes[i];
    push.motion = pushes[j]->motion;
    if (push != *pushes[j]) {
      throw InputError(fmt::format(
          "perturbations: the pushes of cases {} and {} differ; they are compared, so make them "
          "equal",
          kAllCases[i].id, kAllCases[j].id));
    }
    RequireMeasurable(kAllCases[i], *pushes[i], config);
  }
  return pushes;
}

/// Points of each part of the trajectory in a picture.
constexpr int kWayPoints = 24;

class Compliance final : public Application {
 public:
  explicit Compliance(control::ParameterReader& parameters) : config_(ReadConfig(parameters)) {}

  [[nodiscard]] Duration longest(const scenario::Scenario& /*scenario*/) const override {
    Duration all{};
    // The motion back and settling take less than the added time.
    for (const Case& one : kAllCases) all += LengthOf(one, config_) + seconds(5);
    return all;
  }
  void Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override;

 private:
  StepEnd Do(std::size_t index, Stage& stage);
  /// Two pictures: the arm before, and at the end of the push's constant force or of the motion.
  void AddPlan(std::size_t index, const Transform& O_T_EE, Stage& stage) const;

  const Config config_;
  Pushes pushes_;
  JointLimits limits_;
  Spans spans_{};
};

void Compliance::Perform(Stage& stage) {
  if (!stage.scenario.record) {
    throw InputError("record: is false, and the application compliance is judged by its log");
  }
  pushes_ = PushesOf(stage.scenario, config_);
  limits_ = stage.session.robot().limits;
  std::vector<TaskStep> steps;
  for (std::size_t i = 0; i < kCases; ++i) {
    const Case& one = kAllCases[i];
    steps.push_back({.name = fmt::format("{}, {}", one.id, one.what),
                     .act = [this, i, &stage] { return Do(i, stage); }});
    if (i + 1 == kCases) break;
    steps.push_back(
        {.name = fmt::format("back from {}", one.id), .act = [&one, &stage]() -> StepEnd {
           const auto result = stage.Move(MotionBack(one, stage));
           return {result.report.succeeded(), result.report.failure};
         }});
  }
  stage.Carry(steps);
}

StepEnd Compliance::Do(std::size_t index, Stage& stage) {
  const Case& one = kAllCases[index];
  const RobotState state = stage.session.ReadState();
  const run::Motion motion = MotionOf(one, config_, stage, state);
  const Time begun = stage.session.Now();
  const run::MotionResult result = stage.Move(motion);
  spans_[index] = {.begun = begun, .ended = stage.session.Now(), .path = motion.poses};
  if (one.is_pushed || one.kind == Kind::kNullSpace) AddPlan(index, state.O_T_EE, stage);
  return {result.report.succeeded(), result.report.failure};
}

void Compliance::AddPlan(std::size_t index, const Transform& O_T_EE, Stage& stage) const {
  const auto point = [](const Transform& X) { return Vector3{X[12], X[13], X[14]}; };
  const Case& one = kAllCases[index];
  const Span& span = *spans_[index];
  record::PlanRecord plan{
      .id = std::string(one.id),
      .caption = fmt::format("{}: {}; right, {}", one.id, one.what,
                             one.is_pushed ? "while it is pushed" : "at its end"),
      .from = span.begun,
      .until = span.ended,
      .path = {point(O_T_EE)}};
  if (const auto& push = pushes_[index]) {
    plan.until = span.begun + push->begin + push->duration - push->rise;
  }
  const Duration step = config_.leg / kWayPoints;
  for (int i = 1; span.path && i < 3 * kWayPoints; ++i) {
    plan.path.push_back(point(span.path->Sample(i * step).O_T_EE));
  }
  stage.result.plans.push_back(std::move(plan));
}

Evaluation Compliance::Evaluate(const TaskResult& /*task_result*/, const Evidence& evidence) {
  if (evidence.log.empty() || !pushes_[kA]) {
    Evaluation evaluation;
    evaluation.Demand("log of the run", 0, "", "one, to judge by", false);
    return evaluation;
  }
  const Log log = ReadLog(evidence.log, spans_, limits_);
  const Measures measures = Measure(log, config_, pushes_);
  Evaluation evaluation = EvaluateCases(measures);
  evaluation.figures = FiguresOf(log, measures, config_);
  return evaluation;
}

}  // namespace
}  // namespace compliance

std::unique_ptr<Application> MakeCompliance(control::ParameterReader& parameters) {
  return std::make_unique<compliance::Compliance>(parameters);
}

}  // namespace twin::application

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "application/applications.h"
#include "application/compliance.h"
#include "twin/core/error.h"

namespace twin::application {
namespace compliance {
namespace {

/// Points of each part of the trajectory in a picture.
constexpr int kWayPoints = 24;

class Compliance final : public Application {
 public:
  explicit Compliance(control::ParameterReader& parameters) : config_(ReadConfig(parameters)) {}

  [[nodiscard]] control::CommandInterface first_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }
  [[nodiscard]] Duration longest(const scenario::Scenario& scenario) const override;
  [[nodiscard]] TaskResult Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override;

 private:
  StepEnd Do(const Case& one, CaseIndex index, Stage& stage);
  static StepEnd GoBack(const Case& from, Stage& stage);
  /// Two pictures: the arm before, and at the end of the push's constant force or of the motion.
  void AddPlan(const Case& one, const run::Motion& motion, const Transform& O_T_EE, Time begun,
               Time ended);

  const Config config_;
  std::optional<Pushes> pushes_;
  JointLimits limits_;
  std::array<std::optional<Span>, kCases> spans_{};
  std::vector<record::PlanRecord> plans_;
};

Duration Compliance::longest(const scenario::Scenario& /*scenario*/) const {
  Duration all{};
  // The motion back and settling take less than the added time.
  for (const Case& one : kAllCases) all += LengthOf(one, config_) + std::chrono::seconds(5);
  return all;
}

TaskResult Compliance::Perform(Stage& stage) {
  if (!stage.scenario.record) {
    throw InputError("record: is false, and the application compliance is judged by its log");
  }
  pushes_ = PushesOf(stage.scenario, config_);
  limits_ = stage.session.robot().limits;
  std::vector<TaskStep> steps;
  for (std::size_t i = 0; i < kCases; ++i) {
    const Case& one = kAllCases[i];
    const auto index = static_cast<CaseIndex>(i);
    steps.push_back({.name = fmt::format("{}, {}", one.id, one.what),
                     .act = [this, &one, index, &stage] { return Do(one, index, stage); }});
    if (i + 1 == kCases) break;
    steps.push_back({.name = fmt::format("back from {}", one.id),
                     .act = [&one, &stage] { return GoBack(one, stage); }});
  }
  TaskResult task_result{.task = stage.Carry(steps)};
  task_result.plans = std::move(plans_);
  return task_result;
}

StepEnd Compliance::Do(const Case& one, CaseIndex index, Stage& stage) {
  const RobotState state = stage.session.ReadState();
  const run::Motion motion = MotionOf(one, config_, stage, state);
  const Time begun = stage.session.Now();
  const run::MotionResult result = stage.session.Move(motion);
  spans_[index] = {.begun = begun, .ended = stage.session.Now(), .path = motion.poses};
  if (one.is_pushed || one.kind == Kind::kNullSpace) {
    AddPlan(one, motion, state.O_T_EE, begun, stage.session.Now());
  }
  return {result.report.succeeded(), result.report.failure};
}

StepEnd Compliance::GoBack(const Case& from, Stage& stage) {
  const RobotState state = stage.session.ReadState();
  const run::MotionResult result = stage.session.Move(MotionBack(from, stage, state));
  return {result.report.succeeded(), result.report.failure};
}

void Compliance::AddPlan(const Case& one, const run::Motion& motion, const Transform& O_T_EE,
                         Time begun, Time ended) {
  const auto point = [](const Transform& X) { return Vector3{X[12], X[13], X[14]}; };
  record::PlanRecord plan{
      .id = std::string(one.id),
      .caption = fmt::format("{}: {}; right, {}", one.id, one.what,
                             one.is_pushed ? "while it is pushed" : "at its end"),
      .from = begun,
      .until = ended,
      .path = {point(O_T_EE)}};
  if (one.is_pushed) {
    const plant::Push& push = one.kind == Kind::kStandstill ? pushes_->standing : pushes_->moving;
    plan.until = begun + push.begin + push.duration - push.rise;
  }
  if (motion.poses) {
    const Duration step = config_.leg / kWayPoints;
    for (int i = 1; i < 3 * kWayPoints; ++i) {
      plan.path.push_back(point(motion.poses->Sample(i * step).O_T_EE));
    }
  }
  plans_.push_back(std::move(plan));
}

Evaluation Compliance::Evaluate(const TaskResult& /*task_result*/, const Evidence& evidence) {
  if (evidence.log.empty() || !pushes_) {
    Evaluation evaluation;
    evaluation.Demand("log of the run", 0, "", "one, to judge by", false);
    return evaluation;
  }
  const Log log = ReadLog(evidence.log, spans_, limits_);
  const Measures measures = Measure(log, config_, *pushes_);
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

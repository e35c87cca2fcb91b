#include <algorithm>
#include <chrono>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "application/applications.h"
#include "application/teleoperation.h"
#include "twin/backend/hand.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/scenario/objects.h"
#include "twin/scenario/operator.h"
#include "twin/teleop/teleoperator.h"

namespace twin::application {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using teleop::Teleoperator;
using teleop::TeleoperatorStatus;

constexpr const char* kScriptedDevice = "person";
constexpr Duration kAttend = milliseconds(10);
constexpr int kAttendsPerSample = 5;
/// Shortest phase shown in the report.
constexpr Duration kShortest = seconds(2);
/// Default longest duration: of the scripted operator, and of others.
constexpr Duration kScriptedTakes = seconds(240);
constexpr Duration kAnyoneTakes = seconds(1800);
constexpr double kHalfTurn = std::numbers::pi;
constexpr double kFarTarget = 100;  // m

/// The scenario's parameters; missing ones get the paper's gains of teleoperation.
control::Parameters WithPaperGains(control::Parameters given) {
  const control::Parameters otherwise{{.key = "stiffness.translation", .values = {"900 N/m"}},
                                      {.key = "stiffness.rotation", .values = {"90 Nm/rad"}},
                                      {.key = "damping.translation", .values = {"100 Ns/m"}},
                                      {.key = "damping.rotation",
                                       .values = {"10 Nms/rad", "1 Nms/rad", "1 Nms/rad"},
                                       .is_list = true},
                                      {.key = "k0", .values = {"0.3 Nm/rad"}},
                                      {.key = "reference", .values = {"live"}}};
  for (const control::Parameter& parameter : otherwise) {
    const bool is_given = std::ranges::any_of(
        given, [&](const control::Parameter& one) { return one.key == parameter.key; });
    if (!is_given) given.push_back(parameter);
  }
  return given;
}

/// Hand commands at the operator's presses.
struct HandConfig {
  double width = 0.04;  ///< m, of the grasped object, +- tolerance
  double tolerance = 0.04;
  double force = 30;    ///< N
  double speed = 0.05;  ///< m/s
};

class Teleoperation final : public Application {
 public:
  explicit Teleoperation(control::ParameterReader& p)
      : controller_(WithPaperGains(p.Below("controller"))) {
    task_.object = p.Text("object", "");
    task_.from_yaw = p.Quantity("from.heading", Dimension::kAngle, 0, -kHalfTurn, kHalfTurn);
    task_.to = p.Vector("to.position", Dimension::kLength, {}, -kFarTarget, kFarTarget);
    task_.to_yaw = p.Quantity("to.heading", Dimension::kAngle, 0, -kHalfTurn, kHalfTurn);
    task_.reach = p.Quantity("reach", Dimension::kLength, task_.reach, 0.3, 0.7);
    const Duration longest = p.Time("longest", kScriptedTakes, seconds(1), std::chrono::hours(1));
    if (p.Has("longest")) longest_ = longest;
    grip_.force = p.Quantity("grasp.force", Dimension::kForce, grip_.force, 1, 140);
    grip_.speed = p.Quantity("grasp.speed", Dimension::kVelocity, grip_.speed, 0.001, 0.1);
    operator_.hand_noise = p.Number("person.hand_noise", operator_.hand_noise, 0, 0.5);
    operator_.tremor = p.Number("person.tremor", operator_.tremor, 0, 0.2);
    operator_.eye_noise =
        p.Quantity("person.eye_noise", Dimension::kLength, operator_.eye_noise, 0, 0.05);
    operator_.far_noise =
        p.Quantity("person.far_noise", Dimension::kLength, operator_.far_noise, 0, 0.1);
    operator_.reaction =
        p.Time("person.reaction", operator_.reaction, Duration::zero(), seconds(1));
  }

  void Require(const scenario::Scenario& scenario) const override;
  [[nodiscard]] control::CommandInterface first_interface() const noexcept override {
    return control::CommandInterface::kTorque;
  }
  [[nodiscard]] Duration longest(const scenario::Scenario& scenario) const override {
    return LastsFor(scenario) + seconds(10);
  }
  [[nodiscard]] bool drives_base() const noexcept override { return true; }
  [[nodiscard]] TaskResult Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& /*task_result*/,
                                    const Evidence& evidence) override {
    return EvaluateTeleoperation(record_, evidence);
  }

 private:
  [[nodiscard]] Duration LastsFor(const scenario::Scenario& scenario) const;
  [[nodiscard]] FetchTask TaskOf(const scenario::Scenario& scenario) const;
  [[nodiscard]] std::unique_ptr<teleop::Device> MakeDevice(const Stage& stage);
  StepEnd Lead();
  /// Runs beside the motion: hand, snapshots, trace.
  Time Attend(Time now);
  void TendHand(std::uint32_t presses);
  void BeginPlan(teleop::Mode mode, Time now);

  FetchTask task_;  ///< from the parameters, without size and place of the object
  std::optional<Duration> longest_;
  const control::Parameters controller_;
  HandConfig grip_;
  ScriptedOperatorConfig operator_;

  const MonotonicClock clock_;  ///< of devices' own threads
  Stage* stage_ = nullptr;      ///< set while it performs
  std::unique_ptr<teleop::Device> device_;
  ScriptedOperator* scripted_ = nullptr;  ///< device_, if it is one
  std::optional<Teleoperator> teleoperator_;
  std::uint32_t presses_ = 0;  ///< executed presses of the hand's button
  int attends_ = 0;
  TeleoperatorStatus last_{};
  TeleoperationRecord record_;
  TaskResult task_result_;
};

void Teleoperation::Require(const scenario::Scenario& scenario) const {
  if (!scenario.operator_section) {
    throw InputError(
        "application teleoperation: nobody leads; say who, as operator: {device: person}");
  }
  const bool is_scripted = scenario.operator_section->device == kScriptedDevice;
  if (is_scripted || !task_.object.empty()) static_cast<void>(TaskOf(scenario));
  if (!is_scripted) return;
  control::ParameterReader(scenario.operator_section->parameters, "operator.parameters")
      .RefuseUnread();
  if (!scenario.is_lockstep()) {
    throw InputError(
        "operator: the scripted person sees the simulation and is for drive: lockstep only; name a "
        "device that somebody holds");
  }
  if (!scenario.base) {
    throw InputError(
        "operator: the scripted person drives a base, and there is none; say base: {model: husky}, "
        "or name another device");
  }
}

Duration Teleoperation::LastsFor(const scenario::Scenario& scenario) const {
  const bool is_scripted = scenario.operator_section->device == kScriptedDevice;
  return longest_.value_or(is_scripted ? kScriptedTakes : kAnyoneTakes);
}

FetchTask Teleoperation::TaskOf(const scenario::Scenario& scenario) const {
  const auto named =
      std::ranges::find(scenario.objects, task_.object, &scenario::ObjectSection::name);
  if (named == scenario.objects.end()) {
    throw InputError(fmt::format(
        "application.parameters.object: \"{}\" is none of the scenario's objects; name one that is "
        "to be fetched",
        task_.object));
  }
  const auto drawn = ObjectsOf(scenario.objects, scenario.seed);
  const plant::SceneObject& object =
      drawn[static_cast<std::size_t>(named - scenario.objects.begin())];
  FetchTask task = task_;
  task.height = object.size[2];
  task.from = named->pose.position;
  task.to[2] += object.size[2] / 2;
  return task;
}

std::unique_ptr<teleop::Device> Teleoperation::MakeDevice(const Stage& stage) {
  const scenario::OperatorSection& section = *stage.scenario.operator_section;
  if (section.device == kScriptedDevice) {
    const plant::TruthProbe* truth = stage.session.connection().truth;
    if (truth == nullptr) {
      throw InputError(
          "operator: the scripted person sees nothing of this plant; say plant: "
          "{kind: mujoco}");
    }
    auto scripted = std::make_unique<ScriptedOperator>(*truth, record_.task, operator_,
                                                       record_.config, stage.scenario.seed);
    scripted_ = scripted.get();
    return scripted;
  }
  if (stage.devices == nullptr) {
    throw InputError(fmt::format("operator.device: \"{}\" is unknown here; there is: {}",
                                 section.device, kScriptedDevice));
  }
  control::ParameterReader reader(section.parameters, "operator.parameters");
  auto device = stage.devices->Find(section.device)({.parameters = reader,
                                                     .folder = stage.scenario.places.folder,
                                                     .clock = clock_,
                                                     .is_lockstep = stage.scenario.is_lockstep(),
                                                     .seed = stage.scenario.seed});
  reader.RefuseUnread();
  return device;
}

TaskResult Teleoperation::Perform(Stage& stage) {
  stage_ = &stage;
  const scenario::OperatorSection& section = *stage.scenario.operator_section;
  record_.config = MakeTeleoperator(section);
  if (!task_.object.empty()) record_.task = TaskOf(stage.scenario);
  device_ = MakeDevice(stage);
  teleoperator_.emplace(
      Teleoperator::Parts{
          .device = *device_, .base = stage.session.base(), .limits = stage.session.robot().limits},
      record_.config, MakeWire(section), stage.scenario.seed);
  if (stage.tell) stage.tell(fmt::format("led by {}", device_->Describe()));
  task_result_.task = stage.Carry({{.name = "teleoperation", .act = [this] { return Lead(); }}});
  // These refer to the session, so they end with it.
  teleoperator_.reset();
  scripted_ = nullptr;
  device_.reset();
  stage_ = nullptr;
  return std::move(task_result_);
}

StepEnd Teleoperation::Lead() {
  run::Session& session = stage_->session;
  run::Motion motion =
      run::MotionOn(stage_->scenario, "teleoperation", control::CommandInterface::kTorque,
                    run::StandingFor(session.ReadState().q, LastsFor(stage_->scenario),
                                     stage_->session.robot().limits));
  motion.controller.type = "compliance";
  motion.controller.parameters = controller_;
  // Operators touch objects, and a contact is a step in the damping's torque.
  motion.tick.limiter = true;
  motion.live = &*teleoperator_;
  motion.attend = [this](Time now) { return Attend(now); };
  BeginPlan(teleop::Mode::kArm, session.Now());
  const run::MotionResult result = session.Move(motion);
  record_.trace.push_back(teleoperator_->TakeStatus());
  record_.trace.back().now = session.Now();
  task_result_.plans.back().until = session.Now();
  if (result.report.errors.any()) record_.robot_errors.push_back(result.report.failure);
  if (!result.report.succeeded()) return {false, result.report.failure};
  if (scripted_ == nullptr) return {};
  record_.motions = scripted_->motions();
  const std::string why = scripted_->failure();
  return {why.empty(),
          why.empty() ? fmt::format("{} motions of the person", record_.motions) : why};
}

Time Teleoperation::Attend(Time now) {
  TendHand(teleoperator_->gripper_presses());
  const TeleoperatorStatus& status = teleoperator_->TakeStatus();
  if (status.mode != last_.mode) {
    ++record_.switches;
    stage_->session.Tell("operator",
                         status.mode == teleop::Mode::kBase ? "leads the base" : "leads the arm");
    BeginPlan(status.mode, now);
  }
  if (status.stopped != last_.stopped) {
    stage_->session.Tell("operator", status.stopped ? "emergency stop" : "stop released");
  }
  if (status.holding != last_.holding) {
    stage_->session.Tell("operator", status.holding ? "nobody leads" : "somebody leads");
  }
  last_ = status;
  if (attends_++ % kAttendsPerSample == 0) record_.trace.push_back(status);
  return now + kAttend;
}

void Teleoperation::TendHand(std::uint32_t presses) {
  const std::uint32_t since = presses - std::exchange(presses_, presses);
  backend::Hand* hand = stage_->session.connection().hand;
  if (since % 2 == 0 || hand == nullptr) return;
  const bool closes = presses % 2 == 1;
  const HandCommand command =
      closes ? HandCommand(hand::Grasp{.width = grip_.width,
                                       .speed = grip_.speed,
                                       .force = grip_.force,
                                       .epsilon_inner = grip_.tolerance,
                                       .epsilon_outer = grip_.tolerance})
             : HandCommand(hand::Move{.width = kHandStroke, .speed = grip_.speed});
  try {
    static_cast<void>(hand->Start(command));
    stage_->session.Tell("operator", closes ? "closes the hand" : "opens the hand");
    BeginPlan(last_.mode, stage_->session.Now());
  } catch (const Error& error) {
    stage_->session.Tell("operator", error.what());
  }
}

void Teleoperation::BeginPlan(teleop::Mode mode, Time now) {
  std::vector<record::PlanRecord>& plans = task_result_.plans;
  if (!plans.empty()) plans.back().until = now;
  // Drops a phase that is too short to show.
  if (!plans.empty() && now - plans.back().from < kShortest) plans.pop_back();
  const bool drives = mode == teleop::Mode::kBase;
  const bool holds = presses_ % 2 == 1;
  plans.push_back({.id = fmt::format("{}_{}", drives ? "base" : "arm", plans.size() + 1),
                   .caption = fmt::format("{}; the hand is {}",
                                          drives ? "The base is led, the arm holds its pose on it"
                                                 : "The arm is led, the base stands",
                                          holds ? "closed" : "open"),
                   .from = now,
                   .until = now});
}

}  // namespace

std::unique_ptr<Application> MakeTeleoperation(control::ParameterReader& parameters) {
  return std::make_unique<Teleoperation>(parameters);
}

}  // namespace twin::application

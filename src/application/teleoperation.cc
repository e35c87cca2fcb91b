#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "application/applications.h"
#include "application/scripted_operator.h"
#include "twin/backend/hand.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/planning/collision_world.h"
#include "twin/scenario/objects.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/motion_guard.h"
#include "twin/teleop/teleoperator.h"
#include "twin/teleop/teleoperator_config.h"

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

constexpr double kMostObjectError = 0.03;  // m, from the target
constexpr double kMostArmError = 0.01;     // m, of the arm on a base that drives
/// Margin for rounding of third differences and drift of the session's clock.
constexpr double kRounding = 1.02;
constexpr double kOperatorSpeed = 0.2;  // m/s, of a quick hand
constexpr double kMostTilt = 0.05;      // of the object's axis: 1 - cos, some 18 degrees

/// The scenario's parameters; missing ones get the paper's gains of teleoperation, except that the
/// null space follows the operator's posture instead of drifting (k0: 0.3 Nm/rad in the paper).
control::Parameters WithPaperGains(control::Parameters given) {
  const control::Parameters otherwise{{.key = "stiffness.translation", .values = {"900 N/m"}},
                                      {.key = "stiffness.rotation", .values = {"90 Nm/rad"}},
                                      {.key = "damping.translation", .values = {"100 Ns/m"}},
                                      {.key = "damping.rotation",
                                       .values = {"10 Nms/rad", "1 Nms/rad", "1 Nms/rad"},
                                       .is_list = true},
                                      {.key = "k0", .values = {"60 Nm/rad"}},
                                      {.key = "reference", .values = {"live"}}};
  for (const control::Parameter& parameter : otherwise) {
    const bool is_given = std::ranges::any_of(
        given, [&](const control::Parameter& one) { return one.key == parameter.key; });
    if (!is_given) given.push_back(parameter);
  }
  return given;
}

/// The scene's fixed bodies, as the planner sees them.
class FixedBodies final : public teleop::Surroundings {
 public:
  explicit FixedBodies(std::unique_ptr<planning::CollisionWorld> world)
      : world_(std::move(world)) {}

  [[nodiscard]] std::size_t Near(const JointVector& q, const BasePose& base, double horizon,
                                 std::span<teleop::Obstacle> near) noexcept override {
    world_->MoveBase(base);
    std::array<planning::Clearance, teleop::MotionGuard::kMostObstacles> found;
    const std::size_t count =
        world_->NearFixed(q, horizon, std::span(found).first(std::min(found.size(), near.size())));
    for (std::size_t i = 0; i < count; ++i) near[i] = {found[i].distance, found[i].gradient};
    return count;
  }

 private:
  std::unique_ptr<planning::CollisionWorld> world_;
};

std::vector<report::Figure> TeleoperationFigures(const std::vector<TeleoperatorStatus>& trace) {
  report::Figure led{.id = "led", .columns = "t [s],ahead [m/s],turning [rad/s],arm [m/s]"};
  report::Figure error{.id = "error", .columns = "t [s],error [mm]"};
  report::Figure port{.id = "port", .columns = "t [s],force [N],x [mJ],y [mJ],z [mJ]"};
  for (const TeleoperatorStatus& s : trace) {
    const double t = ToSeconds(s.now.time_since_epoch());
    led.rows.push_back({t, s.base_twist.v, s.base_twist.w, HalfNorm(s.target.O_dP_EE, 0)});
    error.rows.push_back({t, 1e3 * s.arm_error});
    port.rows.push_back(
        {t, HalfNorm(s.felt, 0), 1e3 * s.energy[0], 1e3 * s.energy[1], 1e3 * s.energy[2]});
  }
  return {std::move(led), std::move(error), std::move(port)};
}

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
    grasp_.force = p.Quantity("grasp.force", Dimension::kForce, grasp_.force, 1, 140);
    grasp_.speed = p.Quantity("grasp.speed", Dimension::kVelocity, grasp_.speed, 0.001, 0.1);
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
  [[nodiscard]] Duration longest(const scenario::Scenario& scenario) const override {
    return LastsFor(scenario) + seconds(10);
  }
  void Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override;

 private:
  [[nodiscard]] Duration LastsFor(const scenario::Scenario& scenario) const;
  [[nodiscard]] FetchTask TaskOf(const scenario::Scenario& scenario) const;
  [[nodiscard]] std::unique_ptr<teleop::Device> MakeDevice(const Stage& stage);
  StepEnd Lead();
  /// Runs beside the motion: hand, snapshots, trace.
  Time Attend(Time now);
  void TendHand(std::uint32_t presses);
  [[nodiscard]] HandCommand FingerCommand(bool closes) const;
  [[nodiscard]] HandCommand SuctionCommand(bool closes) const;
  void BeginPlan(teleop::Mode mode, Time now);
  void EvaluateObject(const Evidence& evidence, Evaluation& evaluation) const;
  void EvaluateCommands(Evaluation& evaluation) const;

  FetchTask task_;  ///< from the parameters; size and place of the object from Perform() on
  std::optional<Duration> longest_;
  const control::Parameters controller_;
  /// At the operator's presses; an object between the fingers may have any width.
  hand::Grasp grasp_{
      .width = 0.04, .speed = 0.05, .force = 30, .epsilon_inner = 0.04, .epsilon_outer = 0.04};
  hand::Vacuum vacuum_{.vacuum = 75, .timeout_ms = 1000};
  ScriptedOperatorConfig operator_;

  const MonotonicClock clock_;  ///< of devices' own threads
  Stage* stage_ = nullptr;      ///< set while it performs
  std::unique_ptr<teleop::Device> device_;
  ScriptedOperator* scripted_ = nullptr;  ///< device_, if it is one
  std::optional<Teleoperator> teleoperator_;
  std::uint32_t presses_ = 0;  ///< executed presses of the hand's button
  int attends_ = 0;
  TeleoperatorStatus last_{};
  teleop::TeleoperatorConfig config_;
  std::vector<TeleoperatorStatus> trace_{};  ///< every 50 ms
  int switches_ = 0;                         ///< mode switches
  int motions_ = 0;                          ///< of the scripted operator
};

void Teleoperation::Require(const scenario::Scenario& scenario) const {
  if (!scenario.operator_section) {
    throw InputError(
        "application teleoperation: needs an operator; say operator: {device: person}");
  }
  const bool is_scripted = scenario.operator_section->device == kScriptedDevice;
  if (is_scripted || !task_.object.empty()) static_cast<void>(TaskOf(scenario));
  if (!is_scripted) return;
  control::ParameterReader(scenario.operator_section->parameters, "operator.parameters")
      .RefuseUnread();
  if (!scenario.is_lockstep()) {
    throw InputError(
        "operator: the scripted person sees the simulation and is for drive: lockstep only; name a "
        "device of a human operator");
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
    auto scripted =
        std::make_unique<ScriptedOperator>(*truth, task_, operator_, config_, stage.scenario.seed);
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

void Teleoperation::Perform(Stage& stage) {
  stage_ = &stage;
  const scenario::OperatorSection& section = *stage.scenario.operator_section;
  config_ = MakeTeleoperator(section);
  if (!task_.object.empty()) task_ = TaskOf(stage.scenario);
  device_ = MakeDevice(stage);
  FixedBodies around(stage.MakeWorld());
  teleoperator_.emplace(Teleoperator::Parts{.device = *device_,
                                            .base = stage.session.base(),
                                            .limits = stage.session.robot().limits,
                                            .with_hand = stage.session.connection().hand != nullptr,
                                            .surroundings = &around,
                                            .lab = stage.scenario.limits},
                        config_, MakeWire(section), stage.scenario.seed);
  if (stage.tell) stage.tell(fmt::format("led by {}", device_->Describe()));
  stage.Carry({{.name = "teleoperation", .act = [this] { return Lead(); }}});
  // These refer to the session, so they end with it.
  teleoperator_.reset();
  try {
    device_->Finish();
  } catch (const EnvironmentError& error) {  // told once the other results are there
    stage.result.lost_recording = error.what();
  }
  scripted_ = nullptr;
  device_.reset();
  stage_ = nullptr;
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
  // On the wall clock a controller beside the communication thread may sleep while the torques that
  // it left are sent on and on; so each state gets a torque of its own.
  if (!stage_->scenario.is_lockstep()) {
    motion.loop = loop::LoopKind::kBare;
    motion.tick.period_tolerance = {};
    motion.controller.rate_hz = 1000;
  }
  motion.live = &*teleoperator_;
  motion.attend = [this](Time now) { return Attend(now); };
  BeginPlan(teleop::Mode::kArm, session.Now());
  const run::MotionResult result = stage_->Move(motion);
  trace_.push_back(teleoperator_->TakeStatus());
  trace_.back().now = session.Now();
  stage_->result.plans.back().until = session.Now();
  if (!result.report.succeeded()) return {false, result.report.failure};
  if (scripted_ == nullptr) return {};
  motions_ = scripted_->motions();
  const std::string why = scripted_->failure();
  return {why.empty(), why.empty() ? fmt::format("{} motions of the person", motions_) : why};
}

Time Teleoperation::Attend(Time now) {
  TendHand(teleoperator_->gripper_presses());
  const TeleoperatorStatus& status = teleoperator_->TakeStatus();
  if (status.mode != last_.mode) {
    ++switches_;
    stage_->session.Tell("operator",
                         status.mode == teleop::Mode::kBase ? "leads the base" : "leads the arm");
    BeginPlan(status.mode, now);
  }
  if (status.stopped != last_.stopped) {
    stage_->session.Tell("operator", status.stopped ? "emergency stop" : "stop released");
  }
  if (status.holding != last_.holding) {
    stage_->session.Tell("operator", status.holding ? "no input" : "input");
  }
  last_ = status;
  if (attends_++ % kAttendsPerSample == 0) {
    trace_.push_back(status);
    // The controller's time is the robot's, whose beginning is another.
    if (!stage_->scenario.is_lockstep()) trace_.back().now = now;
  }
  return now + kAttend;
}

HandCommand Teleoperation::FingerCommand(bool closes) const {
  if (closes) return grasp_;
  return hand::Move{.width = kHandStroke, .speed = grasp_.speed};
}

HandCommand Teleoperation::SuctionCommand(bool closes) const {
  if (closes) return vacuum_;
  return hand::DropOff{.timeout_ms = vacuum_.timeout_ms};
}

void Teleoperation::TendHand(std::uint32_t presses) {
  const std::uint32_t since = presses - std::exchange(presses_, presses);
  backend::Hand* hand = stage_->session.connection().hand;
  if (since % 2 == 0 || hand == nullptr) return;
  const bool closes = presses % 2 == 1;
  const bool sucks = stage_->scenario.robot.hand == plant::HandKind::kCobotPump;
  const HandCommand command = sucks ? SuctionCommand(closes) : FingerCommand(closes);
  try {
    static_cast<void>(hand->Start(command));
    stage_->session.Tell("operator", closes ? "closes the hand" : "opens the hand");
    BeginPlan(last_.mode, stage_->session.Now());
  } catch (const Error& error) {
    stage_->session.Tell("operator", error.what());
  }
}

void Teleoperation::BeginPlan(teleop::Mode mode, Time now) {
  std::vector<record::PlanRecord>& plans = stage_->result.plans;
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

void Teleoperation::EvaluateObject(const Evidence& evidence, Evaluation& evaluation) const {
  const std::optional<plant::ObjectTrack> track = evidence.TrackOf(task_.object);
  if (!track) return;
  const Transform& X = track->last.X_WB;
  evaluation.DemandAtMost(
      "object position error",
      1e3 * std::hypot(X[12] - task_.to[0], X[13] - task_.to[1], X[14] - task_.to[2]), "mm",
      1e3 * kMostObjectError);
  evaluation.DemandAtMost("object tilt at the end, 1 - cos", 1 - X[10], "", kMostTilt);
  const plant::Support& now = track->changes.back().now;
  evaluation.DemandAtMost(
      "fingers in contact with the object at the end",
      static_cast<double>(now.left_finger) + static_cast<double>(now.right_finger), "", 0);
}

void Teleoperation::EvaluateCommands(Evaluation& evaluation) const {
  const TeleoperatorStatus& end = trace_.back();
  const teleop::TeleoperatorConfig& most = config_;
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
  evaluation.Add("speed of the arm's reference, largest", end.peaks.along.speed, "m/s");
  evaluation.Add("speed of the base's command, largest", end.peaks.ahead.speed, "m/s");
  // A hand that reverses within one period gets more than the reserve (PassivePort).
  const double turned = most.feedback.most_force * kOperatorSpeed * kCycleSeconds;
  evaluation.DemandAtMost("energy out of the operator's port, largest of the axes",
                          1e3 * std::max(0.0, -end.least_energy), "mJ",
                          1e3 * (most.feedback.reserve + turned));
}

Evaluation Teleoperation::Evaluate(const TaskResult& task_result, const Evidence& evidence) {
  Evaluation evaluation;
  evaluation.DemandNone("errors of the robot", task_result.robot_errors);
  EvaluateObject(evidence, evaluation);
  if (trace_.empty()) return evaluation;
  EvaluateCommands(evaluation);
  evaluation.Add("mode switches", switches_);
  if (motions_ > 0) evaluation.Add("motions by the operator", motions_);
  const TeleoperatorStatus& end = trace_.back();
  evaluation.Add("duration", ToSeconds(end.now.time_since_epoch()), "s");
  evaluation.Add("longest gap between two samples", 1e3 * ToSeconds(end.longest_silence), "ms");
  if (!evidence.log.empty()) evaluation.figures = TeleoperationFigures(trace_);
  return evaluation;
}

}  // namespace

std::unique_ptr<Application> MakeTeleoperation(control::ParameterReader& parameters) {
  return std::make_unique<Teleoperation>(parameters);
}

}  // namespace twin::application

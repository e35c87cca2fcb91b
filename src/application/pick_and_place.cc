#include "application/pick_and_place.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "application/pick_evaluation.h"
#include "application/pick_plan.h"
#include "application/pick_task.h"
#include "twin/application/stage.h"
#include "twin/backend/backend.h"
#include "twin/core/check.h"
#include "twin/core/error.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::application {
namespace {

constexpr double kHandSpeed = 0.1;   // m/s, of the open hand
constexpr double kSameWidth = 1e-3;  // m
constexpr double kSamePlace = 2e-3;  // rad: nearer than this a way begins where it was planned

double LargestDistance(const JointVector& a, const JointVector& b) {
  double largest = 0;
  for (std::size_t i = 0; i < kJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// What people see of a way.
std::string CaptionOf(Leg leg, const PickTask& task) {
  const std::string& name = task.object.name;
  switch (leg) {
    case Leg::kApproach: return fmt::format("Approach: above the {}", name);
    case Leg::kGrasp: return fmt::format("Grasp: down to the {}, and hold it", name);
    case Leg::kLift: return fmt::format("Lift: the {} off the {}", name, task.from);
    case Leg::kTransfer: return fmt::format("Transfer: above the {}, turned on the way", task.to);
    case Leg::kPlace: return fmt::format("Place: down onto the {}, and let go", task.to);
    case Leg::kRetreat: return "Retreat: straight away from it";
  }
  return "";
}

class PickAndPlace final : public Application {
 public:
  explicit PickAndPlace(control::ParameterReader& parameters)
      : parameters_(parameters), controller_(parameters.Below("controller")) {}

  void Require(const scenario::Scenario& scenario) const override;
  [[nodiscard]] control::CommandInterface first_interface() const noexcept override {
    return control::CommandInterface::kJointPosition;
  }
  [[nodiscard]] Duration longest(const scenario::Scenario& /*scenario*/) const override {
    return std::chrono::seconds(120);
  }
  [[nodiscard]] TaskResult Perform(Stage& stage) override;
  [[nodiscard]] Evaluation Evaluate(const TaskResult& task_result,
                                    const Evidence& evidence) override {
    return EvaluatePick(record_, task_result, evidence);
  }

 private:
  StepEnd Plan();
  StepEnd Approach();
  StepEnd Grasp();
  StepEnd Lift();
  StepEnd Carry(Leg leg);
  StepEnd Place();
  StepEnd Release();
  StepEnd Retreat();

  /// Goes a way, planned anew when the arm is not where it begins.
  StepEnd Go(Leg leg);
  StepEnd Follow(const std::string& name, const LegPlan& leg, const JointVector& q);
  /// Where the arm is, at rest and ready to move.
  [[nodiscard]] JointVector Ready();
  StepEnd Open();
  [[nodiscard]] bool Holds() const;
  void TellLoad(const setting::Load& load);
  [[nodiscard]] setting::Load LoadOfObject() const;
  Snapshot& SnapshotOf(Leg leg);
  [[nodiscard]] run::Session& session() const { return stage_->session(); }
  [[nodiscard]] double opening() const { return planner_->OpeningFor(plan_.grip); }

  const PickParameters parameters_;
  const control::Parameters controller_;
  Stage* stage_ = nullptr;  ///< set while it performs
  std::optional<PickPlanner> planner_;
  PickPlan plan_;
  PickRecord record_;
  TaskResult task_result_;
  bool is_around_object_ = false;  ///< the fingers are, without holding it
};

void PickAndPlace::Require(const scenario::Scenario& scenario) const {
  (void)TaskOf(scenario, parameters_);
  if (scenario.robot.hand != plant::HandKind::kNone) return;
  throw InputError(
      "application pick_and_place: robot.hand is none; say robot: {hand: franka_hand}");
}

TaskResult PickAndPlace::Perform(Stage& stage) {
  stage_ = &stage;
  record_.task = TaskOf(stage.scenario(), parameters_);
  record_.limits = stage.robot().limits;
  planner_.emplace(stage.World(),
                   PickRobot{.limits = stage.robot().limits,
                             .cartesian = stage.robot().cartesian,
                             .F_T_NE = stage.robot().F_T_NE,
                             .F_T_EE = stage.F_T_EE()},
                   record_.task, parameters_.options);
  const int tries = parameters_.tries;
  task_result_.task = stage.Carry({{.name = "plan", .act = [this] { return Plan(); }},
                                   {.name = "approach",
                                    .act = [this] { return Approach(); },
                                    .after_failure = "approach",
                                    .attempts = 2},
                                   {.name = "grasp",
                                    .act = [this] { return Grasp(); },
                                    .after_failure = "approach",
                                    .attempts = tries},
                                   {.name = "lift",
                                    .act = [this] { return Lift(); },
                                    .after_failure = "approach",
                                    .attempts = 2},
                                   {.name = "transfer",
                                    .act = [this] { return Carry(Leg::kTransfer); },
                                    .after_failure = "transfer",
                                    .attempts = 2},
                                   {.name = "place",
                                    .act = [this] { return Place(); },
                                    .after_failure = "place",
                                    .attempts = 2},
                                   {.name = "release", .act = [this] { return Release(); }},
                                   {.name = "retreat",
                                    .act = [this] { return Retreat(); },
                                    .after_failure = "retreat",
                                    .attempts = 2}});
  stage_ = nullptr;
  return std::move(task_result_);
}

StepEnd PickAndPlace::Plan() {
  const Time begun = stage_->clock().Now();
  auto planned = planner_->Plan(Ready());
  task_result_.planning_time += stage_->clock().Now() - begun;
  if (auto* why = std::get_if<std::string>(&planned)) return {false, std::move(*why)};
  plan_ = std::move(std::get<PickPlan>(planned));
  const Transform NE_T_EE =
      model::Multiply(model::Inverse(stage_->robot().F_T_NE), stage_->F_T_EE());
  record_.grip = plan_.grip;
  record_.B_T_EE = model::Multiply(plan_.grip.B_T_NE, NE_T_EE);
  record_.moved = plan_.duration;
  return {true, fmt::format("{} ways, {:.1f} s, the hand closes to {:.1f} mm", kLegs,
                            ToSeconds(plan_.duration), plan_.grip.width * 1e3)};
}

JointVector PickAndPlace::Ready() {
  RobotState state = session().ReadState();
  if (state.robot_mode != RobotMode::kIdle) {
    session().Recover();
    state = session().ReadState();
  }
  return state.q_d;
}

Snapshot& PickAndPlace::SnapshotOf(Leg leg) {
  const std::string id(Name(leg));
  const auto found = std::ranges::find(task_result_.snapshots, id, &Snapshot::id);
  return found != task_result_.snapshots.end()
             ? *found
             : task_result_.snapshots.emplace_back(Snapshot{.id = id, .caption = {}});
}

StepEnd PickAndPlace::Go(Leg leg) {
  const JointVector q = Ready();
  const auto number = static_cast<std::size_t>(leg);
  if (LargestDistance(q, plan_.legs[number].q_start) > kSamePlace) {
    const Time begun = stage_->clock().Now();
    auto planned = planner_->PlanFrom(q, leg, plan_.grip);
    task_result_.planning_time += stage_->clock().Now() - begun;
    if (auto* why = std::get_if<std::string>(&planned)) {
      return {false, fmt::format("no way from where the arm is: {}", *why)};
    }
    plan_ = std::move(std::get<PickPlan>(planned));
  }
  const LegPlan& plan = plan_.legs[number];
  Snapshot& snapshot = SnapshotOf(leg);
  snapshot.caption = CaptionOf(leg, record_.task);
  snapshot.planned = session().Now();
  snapshot.goal = plan.q_end;
  snapshot.way = plan.way;
  if (leg == Leg::kLift || leg == Leg::kTransfer || leg == Leg::kPlace) {
    snapshot.object = record_.task.object.name;
    snapshot.O_T_object = model::Multiply(
        model::ArmModel::Panda().Pose(model::Frame::kEndEffector, plan.q_end, stage_->F_T_EE()),
        model::Inverse(record_.B_T_EE));
  }
  StepEnd end = Follow(std::string(Name(leg)), plan, q);
  snapshot.done = session().Now();
  return end;
}

StepEnd PickAndPlace::Follow(const std::string& name, const LegPlan& leg, const JointVector& q) {
  if (leg.poses.empty()) return {true, "already there"};
  LegPlan from_here = leg;
  from_here.poses.front() =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q, stage_->F_T_EE());
  reference::PoseTrajectory poses = PathOf(from_here, stage_->robot().cartesian);
  const Duration duration = poses.duration();
  run::Motion motion = stage_->NewMotion(name, control::CommandInterface::kJointPosition,
                                         run::StandingFor(q, duration, stage_->robot().limits));
  motion.poses = std::move(poses);
  motion.controller.type = "cartesian_pose";
  motion.controller.parameters = controller_;
  const run::MotionResult result = session().Move(motion);
  if (result.report.succeeded()) return {true, fmt::format("{:.2f} s", ToSeconds(duration))};
  if (result.report.errors.any()) record_.robot_errors.push_back(result.report.failure);
  if (!session().interrupted()) session().Recover();
  return {false, result.report.failure};
}

StepEnd PickAndPlace::Open() {
  if (std::abs(session().connection().hand->ReadState().width - opening()) < kSameWidth) return {};
  const run::HandOutcome outcome =
      session().Command(hand::Move{.width = opening(), .speed = kHandSpeed});
  if (outcome.result == HandResult::kSuccess) return {};
  return {false, fmt::format("the hand did not open to {:.1f} mm: it stands at {:.1f} mm. {}",
                             opening() * 1e3, outcome.width * 1e3, outcome.failure)};
}

bool PickAndPlace::Holds() const {
  const HandState hand = session().connection().hand->ReadState();
  return hand.is_grasped && std::abs(hand.width - plan_.grip.width) <= parameters_.tolerance;
}

void PickAndPlace::TellLoad(const setting::Load& load) {
  session().connection().backend->Configure(load);
}

setting::Load PickAndPlace::LoadOfObject() const {
  const Transform F_T_B =
      model::Multiply(stage_->robot().F_T_NE, model::Inverse(plan_.grip.B_T_NE));
  return {.m_load = NominalMass(stage_->scenario(), record_.task.object.name),
          .F_x_Cload = {F_T_B[12], F_T_B[13], F_T_B[14]}};
}

StepEnd PickAndPlace::Approach() {
  if (Holds()) return {true, "the hand holds it already"};
  if (StepEnd open = Open(); !open.succeeded) return open;
  if (is_around_object_) {
    const JointVector q = Ready();
    auto away = planner_->BackOff(q, plan_.grip);
    if (auto* why = std::get_if<std::string>(&away)) return {false, std::move(*why)};
    if (StepEnd end = Follow("back off", std::get<LegPlan>(away), q); !end.succeeded) return end;
    is_around_object_ = false;
  }
  return Go(Leg::kApproach);
}

StepEnd PickAndPlace::Grasp() {
  if (Holds()) return {true, "the hand holds it already"};
  is_around_object_ = true;
  if (StepEnd end = Go(Leg::kGrasp); !end.succeeded) return end;
  const run::HandOutcome outcome =
      session().Command(hand::Grasp{.width = plan_.grip.width,
                                    .speed = parameters_.speed,
                                    .force = parameters_.force,
                                    .epsilon_inner = parameters_.tolerance,
                                    .epsilon_outer = parameters_.tolerance});
  record_.width_grasped = outcome.width;
  SnapshotOf(Leg::kGrasp).done = session().Now();
  if (outcome.result == HandResult::kSuccess && Holds()) {
    return {true, fmt::format("{:.2f} mm wide", outcome.width * 1e3)};
  }
  return {false, fmt::format("the fingers stand at {:.1f} mm, the {} is {:.1f} mm wide. {}",
                             outcome.width * 1e3, record_.task.object.name, plan_.grip.width * 1e3,
                             outcome.failure)};
}

StepEnd PickAndPlace::Carry(Leg leg) {
  const auto lost = [this]() -> StepEnd {
    return {false,
            fmt::format("the hand lost the {}: it stands at {:.1f} mm", record_.task.object.name,
                        session().connection().hand->ReadState().width * 1e3)};
  };
  if (!Holds()) return lost();
  StepEnd end = Go(leg);
  return end.succeeded && !Holds() ? lost() : end;
}

StepEnd PickAndPlace::Lift() {
  static_cast<void>(Ready());
  TellLoad(LoadOfObject());
  return Carry(Leg::kLift);
}

StepEnd PickAndPlace::Place() {
  StepEnd end = Carry(Leg::kPlace);
  if (!end.succeeded) return end;
  record_.is_placed = true;
  record_.O_T_EE_placed = session().ReadState().O_T_EE;
  record_.width_placed = session().connection().hand->ReadState().width;
  return end;
}

StepEnd PickAndPlace::Release() {
  // What is below bears the object from here on: so nothing jerks when the fingers open.
  TellLoad(stage_->scenario().onboard.load);
  StepEnd end = Open();
  SnapshotOf(Leg::kPlace).done = session().Now();
  return end;
}

StepEnd PickAndPlace::Retreat() {
  StepEnd end = Go(Leg::kRetreat);
  if (end.succeeded && session().WaitForRest() != run::WaitEnd::kDone) {
    return {false, "the arm does not come to rest"};
  }
  return end;
}

}  // namespace

std::unique_ptr<Application> MakePickAndPlace(control::ParameterReader& parameters) {
  return std::make_unique<PickAndPlace>(parameters);
}

}  // namespace twin::application

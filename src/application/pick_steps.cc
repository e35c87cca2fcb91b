#include "application/pick_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/backend/backend.h"
#include "twin/core/setting.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::application {
namespace {

constexpr double kOpeningSpeed = 0.1;  // m/s, of the hand
constexpr double kSameWidth = 1e-3;    // m
constexpr double kSameStart = 2e-3;    // rad, from a leg's planned start

}  // namespace

PickSteps::PickSteps(Handling handling, control::Parameters controller)
    : handling_(std::move(handling)), controller_(std::move(controller)) {}

void PickSteps::Begin(Stage& stage, PickTask task) {
  stage_ = &stage;
  const scenario::RobotData& robot = stage.session.robot();
  record_.task = std::move(task);
  record_.limits = robot.limits;
  world_ = stage.MakeWorld();
  planner_.emplace(*world_, robot, stage.clock, stage.F_T_EE(), record_.task, handling_.options,
                   stage.scenario.seed);
}

StepEnd PickSteps::Plan() {
  const Time begun = stage_->clock.Now();
  auto planned = planner_->Plan(Ready());
  stage_->result.planning_time += stage_->clock.Now() - begun;
  if (auto* why = std::get_if<std::string>(&planned)) return {false, std::move(*why)};
  plan_ = std::move(std::get<PickPlan>(planned));
  const Transform NE_T_EE =
      model::Multiply(model::Inverse(session().robot().F_T_NE), stage_->F_T_EE());
  record_.B_T_EE = model::Multiply(plan_.grip.B_T_NE, NE_T_EE);
  record_.moved = plan_.duration;
  const auto sampled =
      std::ranges::count_if(plan_.legs, [](const LegPlan& leg) { return !leg.joints.empty(); });
  return {true, fmt::format("{} ways{}, {:.1f} s, the hand closes to {:.1f} mm", kLegTraits.size(),
                            sampled == 0 ? "" : fmt::format(", {} of them sampled", sampled),
                            ToSeconds(plan_.duration), plan_.grip.width * 1e3)};
}

JointVector PickSteps::Ready() {
  RobotState state = session().ReadState();
  if (state.robot_mode != RobotMode::kIdle) {
    session().Recover();
    state = session().ReadState();
  }
  return state.q_d;
}

record::PlanRecord& PickSteps::RecordOf(Leg leg) {
  const std::string id(kLegTraits[leg].name);
  const auto found = std::ranges::find(stage_->result.plans, id, &record::PlanRecord::id);
  return found != stage_->result.plans.end()
             ? *found
             : stage_->result.plans.emplace_back(record::PlanRecord{.id = id, .caption = {}});
}

StepEnd PickSteps::PlanFrom(Leg leg, const JointVector& q) {
  const Time begun = stage_->clock.Now();
  auto planned = planner_->PlanFrom(q, leg, plan_.grip);
  stage_->result.planning_time += stage_->clock.Now() - begun;
  if (auto* why = std::get_if<std::string>(&planned)) {
    return {false, fmt::format("no way from where the arm is: {}", *why)};
  }
  plan_ = std::move(std::get<PickPlan>(planned));
  return {};
}

StepEnd PickSteps::Go(Leg leg) {
  const JointVector q = Ready();
  const bool is_at_start = std::ranges::equal(
      q, plan_.legs[leg].q_start, [](double a, double b) { return std::abs(a - b) <= kSameStart; });
  if (!is_at_start) {
    if (StepEnd end = PlanFrom(leg, q); !end.succeeded) return end;
  }
  const LegPlan& plan = plan_.legs[leg];
  record::PlanRecord& record = RecordOf(leg);
  const PickTask& task = record_.task;
  record.caption =
      fmt::format(fmt::runtime(kLegTraits[leg].caption), fmt::arg("object", task.object.name),
                  fmt::arg("from", task.from.empty() ? "other hand" : task.from),
                  fmt::arg("to", task.to.empty() ? "meeting place" : task.to));
  record.from = session().Now();
  record.q = plan.q_end;
  record.path = InWorld(plan.path);
  if (kLegTraits[leg].is_held) {
    record.object = task.object.name;
    record.O_T_object = ObjectAt(
        model::ArmModel::Panda().Pose(model::Frame::kEndEffector, plan.q_end, stage_->F_T_EE()));
  }
  StepEnd end = Follow(record.id, plan, q);
  record.until = session().Now();
  return end;
}

Transform PickSteps::ObjectAt(const Transform& O_T_EE) const {
  return model::Multiply(record_.task.X_WO,
                         model::Multiply(O_T_EE, model::Inverse(record_.B_T_EE)));
}

std::vector<Vector3> PickSteps::InWorld(std::vector<Vector3> path) const {
  const Transform& X = record_.task.X_WO;
  for (Vector3& p : path) {
    const Vector3 p_O = p;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = X[12 + i] + X[i] * p_O[0] + X[4 + i] * p_O[1] + X[8 + i] * p_O[2];
    }
  }
  return path;
}

run::Motion PickSteps::OnPoses(const std::string& name, const LegPlan& leg,
                               const JointVector& q) const {
  LegPlan from_here = leg;
  from_here.poses.front() =
      model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q, stage_->F_T_EE());
  reference::PoseTrajectory poses = PathOf(from_here, session().robot().cartesian);
  run::Motion motion =
      run::MotionOn(stage_->scenario, name, control::CommandInterface::kJointPosition,
                    run::StandingFor(q, poses.duration(), session().robot().limits));
  motion.poses = std::move(poses);
  motion.controller.type = "cartesian_pose";
  motion.controller.parameters = controller_;
  return motion;
}

run::Motion PickSteps::OnJoints(const std::string& name, const LegPlan& leg,
                                const JointVector& q) const {
  std::vector<reference::Waypoint> from_here = leg.joints;
  from_here.front().q = q;
  return run::MotionOn(stage_->scenario, name, control::CommandInterface::kJointPosition,
                       reference::Trajectory(from_here, {}, session().robot().limits));
}

StepEnd PickSteps::Follow(const std::string& name, const LegPlan& leg, const JointVector& q) {
  if (leg.is_at_end()) return {true, "already there"};
  const run::MotionResult result =
      stage_->Move(leg.joints.empty() ? OnPoses(name, leg, q) : OnJoints(name, leg, q));
  if (result.report.succeeded()) {
    return {true, fmt::format("{:.2f} s{}", ToSeconds(leg.duration),
                              leg.joints.empty() ? "" : ", sampled in joint space")};
  }
  if (!session().interrupted()) session().Recover();
  return {false, result.report.failure};
}

StepEnd PickSteps::Open() {
  if (std::abs(hand_state().width - opening()) < kSameWidth) return {};
  const run::HandOutcome outcome =
      session().Command(hand::Move{.width = opening(), .speed = kOpeningSpeed});
  if (outcome.result == HandResult::kSuccess) return {};
  return {false, fmt::format("the hand did not open to {:.1f} mm: it stands at {:.1f} mm. {}",
                             opening() * 1e3, outcome.width * 1e3, outcome.failure)};
}

bool PickSteps::Holds() const {
  const HandState state = hand_state();
  return state.is_grasped && std::abs(state.width - plan_.grip.width) <= handling_.tolerance;
}

setting::Load PickSteps::LoadOfObject() const {
  const Transform F_T_B =
      model::Multiply(session().robot().F_T_NE, model::Inverse(plan_.grip.B_T_NE));
  return {.m_load = record_.task.nominal_mass, .F_x_Cload = {F_T_B[12], F_T_B[13], F_T_B[14]}};
}

StepEnd PickSteps::Approach() {
  if (Holds()) return {true, "the hand holds it already"};
  if (StepEnd open = Open(); !open.succeeded) return open;
  if (is_around_object_) {
    const JointVector q = Ready();
    auto away = planner_->BackOff(q, plan_.grip);
    if (auto* why = std::get_if<std::string>(&away)) return {false, std::move(*why)};
    if (StepEnd end = Follow("back off", std::get<LegPlan>(away), q); !end.succeeded) return end;
    is_around_object_ = false;
  }
  return Go(kApproach);
}

StepEnd PickSteps::Grasp() {
  if (Holds()) return {true, "the hand holds it already"};
  is_around_object_ = true;
  if (StepEnd end = Go(kGrasp); !end.succeeded) return end;
  const run::HandOutcome outcome =
      session().Command(hand::Grasp{.width = plan_.grip.width,
                                    .speed = handling_.speed,
                                    .force = handling_.force,
                                    .epsilon_inner = handling_.tolerance,
                                    .epsilon_outer = handling_.tolerance});
  record_.width_grasped = outcome.width;
  RecordOf(kGrasp).until = session().Now();
  if (outcome.result == HandResult::kSuccess && Holds()) {
    return {true, fmt::format("{:.2f} mm wide", outcome.width * 1e3)};
  }
  return {false, fmt::format("the fingers stand at {:.1f} mm, the {} is {:.1f} mm wide. {}",
                             outcome.width * 1e3, record_.task.object.name, plan_.grip.width * 1e3,
                             outcome.failure)};
}

StepEnd PickSteps::Carry(Leg leg) {
  const auto lost = [this]() -> StepEnd {
    return {false, fmt::format("the hand lost the {}: it stands at {:.1f} mm",
                               record_.task.object.name, hand_state().width * 1e3)};
  };
  if (!Holds()) return lost();
  StepEnd end = Go(leg);
  return end.succeeded && !Holds() ? lost() : end;
}

void PickSteps::Bear() {
  static_cast<void>(Ready());
  Configure(LoadOfObject());
}

StepEnd PickSteps::Lift() {
  Bear();
  return Carry(kLift);
}

StepEnd PickSteps::Place() {
  StepEnd end = Carry(kPlace);
  if (!end.succeeded) return end;
  record_.is_placed = true;
  record_.O_T_EE_placed = session().ReadState().O_T_EE;
  record_.width_placed = hand_state().width;
  return end;
}

StepEnd PickSteps::Release() {
  // The surface bears the object from here on, so the arm does not jerk when the fingers open.
  Configure(stage_->scenario.onboard.load);
  StepEnd end = Open();
  RecordOf(kPlace).until = session().Now();
  return end;
}

StepEnd PickSteps::Retreat() {
  StepEnd end = Go(kRetreat);
  if (end.succeeded && session().WaitForRest() != run::WaitEnd::kDone) {
    return {false, "the arm does not come to rest"};
  }
  return end;
}

}  // namespace twin::application

#include "application/pick.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "twin/core/error.h"
#include "twin/core/hand_command.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"
#include "twin/planning/planner.h"
#include "twin/planning/pose_goal.h"

namespace twin::application {
namespace {

using Eigen::Vector3d;

constexpr double kSamePose = 1e-4;  // m and rad
constexpr double kHigher = 0.12;    // m, height of intermediate points
constexpr double kNearer = 0.75;    // share of the distance from the robot, of nearer points
constexpr int kSlowings = 4;
constexpr std::size_t kMostGoals = 24;  // configurations of a sampled path's end
constexpr std::uint64_t kAttempts = 8;  // that share the budget of checks
constexpr std::string_view kStraight = "straight";
constexpr std::string_view kSampled = "sampled";

Transform MovedBy(Transform X, const Vector3d& by) {
  for (std::size_t i = 0; i < 3; ++i) X[12 + i] += by[static_cast<Eigen::Index>(i)];
  return X;
}

bool SamePose(const Transform& a, const Transform& b) {
  return (model::Position(a) - model::Position(b)).norm() < kSamePose &&
         model::TurnBetween(a, b).norm() < kSamePose;
}

/// Half way, nearer to the robot and above both.
Transform Between(const Transform& a, const Transform& b) {
  Vector3d p = (model::Position(a) + model::Position(b)) / 2;
  p.head<2>() *= kNearer;
  p.z() = std::max(a[14], b[14]) + kHigher / 2;
  const Vector3d half_turn = model::TurnBetween(a, b) / 2;
  return model::Pose(model::Exp(half_turn) * model::Orientation(a), p);
}

Duration DurationOf(const PickPlan& plan) {
  Duration sum{};
  for (const LegPlan& leg : plan.legs) sum += leg.duration;
  return sum;
}

std::vector<reference::PoseWaypoint> WaypointsOf(const std::vector<Transform>& poses) {
  std::vector<reference::PoseWaypoint> waypoints;
  waypoints.reserve(poses.size());
  for (const Transform& pose : poses) waypoints.push_back({.O_T_EE = pose});
  return waypoints;
}

}  // namespace

reference::PoseTrajectory PathOf(const LegPlan& leg, const CartesianLimits& limits) {
  return reference::PoseTrajectory(WaypointsOf(leg.poses), {.duration = leg.duration}, limits);
}

PickPlanner::PickPlanner(planning::CollisionWorld& world, const scenario::RobotData& robot,
                         const Clock& clock, const Transform& F_T_EE, PickTask task,
                         const PickOptions& options, std::uint64_t seed)
    : world_(world),
      robot_(robot),
      F_T_EE_(F_T_EE),
      task_(std::move(task)),
      options_(options),
      clock_(clock),
      seed_(seed) {
  world.limits().Lower(robot_.limits);
  world.limits().Lower(robot_.cartesian);
}

Transform PickPlanner::PoseAt(const JointVector& q) const noexcept {
  return model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q, F_T_EE_);
}

double PickPlanner::OpeningFor(const Grip& grip) const noexcept {
  return std::min(kHandStroke, grip.width + options_.room);
}

std::vector<PickPlanner::Route> PickPlanner::RoutesOf(Leg leg, const Transform& here,
                                                      const Grip& grip) const {
  const Transform NE_T_EE = model::Multiply(model::Inverse(robot_.F_T_NE), F_T_EE_);
  const Transform B_T_EE = model::Multiply(grip.B_T_NE, NE_T_EE);
  const Vector3d from_up = Vector3d(task_.from_up.data());
  const Vector3d to_up = Vector3d(task_.to_up.data());
  const Transform at_object = model::Multiply(task_.object.X_WB, B_T_EE);
  const Transform above_object = MovedBy(at_object, options_.above * from_up);
  const Transform at_goal = MovedBy(model::Multiply(task_.O_T_goal, B_T_EE), options_.gap * to_up);
  const Transform above_goal = MovedBy(at_goal, options_.above * to_up);
  const Vector3d higher(0, 0, kHigher);
  switch (leg) {
    case kApproach:
      return {
          {kStraight, {above_object}},
          {"over a point above", {MovedBy(above_object, higher), above_object}},
          {"up and over", {MovedBy(here, higher), MovedBy(above_object, higher), above_object}}};
    case kGrasp: return {{kStraight, {at_object}}};
    case kLift: return {{kStraight, {above_object}}};
    case kTransfer: {
      const double rise = std::max(0.0, above_goal[14] - here[14]);
      const Transform risen = MovedBy(here, Vector3d(0, 0, rise));
      return {
          {kStraight, {above_goal}},
          {"up first", {risen, above_goal}},
          {"nearer to the robot", {Between(here, above_goal), above_goal}},
          {"up and over", {MovedBy(risen, higher), MovedBy(above_goal, higher), above_goal}},
          {"up first, then nearer to the robot", {risen, Between(risen, above_goal), above_goal}}};
    }
    case kPlace: return {{kStraight, {at_goal}}};
    case kRetreat: {
      const Vector3d away =
          model::Orientation(task_.O_T_goal) * Vector3d(grip.B_up.data()) * options_.above;
      const Transform clear = MovedBy(at_goal, away);
      return {{kStraight, {clear, MovedBy(clear, Vector3d(task_.withdraw.data()))}}};
    }
    case kLegs: break;
  }
  return {};
}

void PickPlanner::SetWorld(Leg leg, const Grip& grip) {
  const std::string& name = task_.object.name;
  world_.Detach();
  world_.ForbidAll();
  const bool is_held = kLegTraits[leg].is_held;
  world_.SetHandWidth(is_held ? grip.width : OpeningFor(grip));
  if (is_held) {
    world_.Attach(name, model::Multiply(robot_.F_T_NE, model::Inverse(grip.B_T_NE)));
    const std::string& support = leg == kPlace ? task_.to : task_.from;
    if ((leg == kLift || leg == kPlace) && !support.empty()) world_.Allow(name, support);
  } else {
    const Transform& O_T_B = leg == kRetreat ? task_.O_T_goal : task_.object.X_WB;
    world_.Place(name, model::Multiply(task_.X_WO, O_T_B));
  }
  if (task_.around) task_.around(world_, leg);
}

OrReason<std::vector<JointVector>> PickPlanner::Follow(LegPlan& leg, const JointVector& q,
                                                       const reference::Timing& pace) const {
  reference::PoseTrajectory path(WaypointsOf(leg.poses), pace, robot_.cartesian);
  for (int slowing = 0;; ++slowing) {
    auto outcome = planning::Follow(path, q, F_T_EE_, robot_.limits, options_.follow);
    if (auto* why = std::get_if<std::string>(&outcome)) return std::move(*why);
    auto& followed = std::get<planning::Followed>(outcome);
    leg.duration = path.duration();
    const double slower = std::max(followed.velocity_load, std::sqrt(followed.acceleration_load));
    if (slower <= 1) return std::move(followed.q);
    if (slowing == kSlowings) {
      return fmt::format("near a singularity: the joints would be {:.1f} times too fast", slower);
    }
    leg.duration = FromSeconds(1.02 * slower * ToSeconds(leg.duration));
    path = PathOf(leg, robot_.cartesian);
  }
}

OrReason<LegPlan> PickPlanner::Try(const Route& route, const JointVector& q,
                                   const reference::Timing& pace, double clearance) {
  LegPlan leg{.poses = {PoseAt(q)}, .q_start = q, .q_end = q};
  for (const Transform& pose : route.poses) {
    if (!SamePose(leg.poses.back(), pose)) leg.poses.push_back(pose);
  }
  if (leg.poses.size() == 1) return LegPlan{.q_start = q, .q_end = q};
  try {
    auto outcome = Follow(leg, q, pace);
    if (auto* why = std::get_if<std::string>(&outcome)) return std::move(*why);
    const auto& joints = std::get<std::vector<JointVector>>(outcome);
    if (auto touch = planning::FirstTouch(world_, joints, clearance)) return std::move(*touch);
    leg.q_end = joints.back();
    leg.path = EndEffectorPath(joints, F_T_EE_);
    return leg;
  } catch (const InputError& error) {  // half a turn has no shortest path
    return error.what();
  }
}

void PickPlanner::Note(Leg leg, std::string_view way, const std::string& why) {
  Trial& trial = trials_[grip_];
  if (leg < trial.leg) return;
  if (leg > trial.leg) trial = {.leg = leg};
  const auto same = [way](const auto& failure) { return failure.first == way; };
  if (std::ranges::none_of(trial.failures, same)) trial.failures.emplace_back(way, why);
}

bool PickPlanner::Search(const JointVector& q, Leg leg, PickPlan& plan) {
  if (leg == kLegs) return true;
  const bool is_across = leg == kApproach || leg == kTransfer;
  const bool is_down = leg == kGrasp || leg == kPlace;
  const std::vector<Route> routes = RoutesOf(leg, PoseAt(q), plan.grip);
  for (const Route& route : routes) {
    SetWorld(leg, plan.grip);
    auto tried = Try(route, q, is_down ? options_.down_pace : options_.pace,
                     is_across ? options_.clearance : options_.near);
    if (const auto* why = std::get_if<std::string>(&tried)) {
      Note(leg, route.name, *why);
      continue;
    }
    plan.legs[leg] = std::move(std::get<LegPlan>(tried));
    if (Search(plan.legs[leg].q_end, static_cast<Leg>(leg + 1), plan)) return true;
  }
  return is_across && samples_ && SearchSampled(q, leg, routes.front().poses.back(), plan);
}

bool PickPlanner::SearchSampled(const JointVector& q, Leg leg, const Transform& O_T_EE,
                                PickPlan& plan) {
  if (checks_left_ == 0) {
    Note(leg, kSampled,
         fmt::format("the budget of {} collision checks is used up", options_.budget));
    return false;
  }
  SetWorld(leg, plan.grip);
  auto found = planning::ConfigurationsAt(model::Multiply(O_T_EE, model::Inverse(F_T_EE_)),
                                          robot_.limits, world_,
                                          {.near = q,
                                           .clearance = options_.clearance,
                                           .limit_margin = options_.follow.limit_margin,
                                           .most = kMostGoals});
  if (const auto* none = std::get_if<planning::NoPose>(&found)) {
    Note(leg, kSampled, none->text);
    return false;
  }
  for (const JointVector& goal : std::get<std::vector<JointVector>>(found)) {
    // The next legs first: they cost less.
    if (!Search(goal, static_cast<Leg>(leg + 1), plan)) continue;
    SetWorld(leg, plan.grip);
    auto sampled = Sample(q, goal);
    if (const auto* why = std::get_if<std::string>(&sampled)) {
      Note(leg, kSampled, *why);
      if (checks_left_ == 0) return false;
      continue;
    }
    plan.legs[leg] = std::move(std::get<LegPlan>(sampled));
    return true;
  }
  return false;
}

OrReason<LegPlan> PickPlanner::Sample(const JointVector& q, const JointVector& goal) {
  const std::uint64_t most = std::max<std::uint64_t>(1, options_.budget / kAttempts);
  planning::Planner planner(world_, robot_.limits, clock_,
                            {.most_checks = std::min(checks_left_, most),
                             .clearance = options_.clearance,
                             .limit_margin = options_.follow.limit_margin,
                             .pace = options_.pace});
  try {
    planning::PlanOutcome outcome = planner.ToConfiguration(q, goal, seed_);
    if (auto* failure = std::get_if<planning::PlanFailure>(&outcome)) {
      checks_left_ -= std::min(checks_left_, failure->statistics.checks);
      return std::move(failure->text);
    }
    auto& plan = std::get<planning::Plan>(outcome);
    checks_left_ -= std::min(checks_left_, plan.statistics.checks);
    return LegPlan{.joints = std::move(plan.waypoints),
                   .duration = plan.trajectory.duration(),
                   .q_start = q,
                   .q_end = goal,
                   .path = EndEffectorPath(plan.trajectory, F_T_EE_)};
  } catch (const InputError& error) {  // start or goal is too close to a joint limit
    return error.what();
  }
}

std::string PickPlanner::Furthest() const {
  const auto best = std::ranges::max_element(trials_, {}, &Trial::leg);
  std::string text = fmt::format("the way \"{}\"", kLegTraits[best->leg].name);
  for (const auto& [way, why] : best->failures) text += fmt::format("; {}: {}", way, why);
  return text;
}

OrReason<PickPlan> PickPlanner::Plan(const JointVector& q) {
  const std::vector<Grip> grips = GripsOf(task_.object, task_.from_up,
                                          {.palm = options_.clearance + 2e-3,
                                           .below = options_.near + 3e-3,
                                           .beside = options_.near + 1e-3},
                                          task_.grip);
  if (grips.empty()) {
    return fmt::format(
        "{} ({} x {} x {} m) cannot be gripped from above{}: it is too wide for the hand, which "
        "opens by {} m, or too flat{}",
        task_.object.name, task_.object.size[0], task_.object.size[1], task_.object.size[2],
        task_.grip.off_centre == 0 ? ""
                                   : fmt::format(" at {} m from its middle", task_.grip.off_centre),
        kHandStroke, task_.grip.off_centre == 0 ? "" : ", or too short");
  }
  SetWorld(kApproach, grips.front());
  if (const auto touches = world_.Touches(q, options_.clearance); !touches.empty()) {
    return fmt::format("the arm cannot leave where it stands: {}; move it away, or what is there",
                       planning::Describe(touches));
  }
  trials_.assign(grips.size(), {});
  checks_left_ = options_.budget;
  std::optional<PickPlan> best;
  for (const bool samples : {false, true}) {
    samples_ = samples;
    for (grip_ = 0; grip_ < grips.size(); ++grip_) {
      if (best && samples) return std::move(*best);
      PickPlan plan{.grip = grips[grip_], .legs = {}};
      if (!Search(q, kApproach, plan)) continue;
      plan.duration = DurationOf(plan);
      if (!best || plan.duration < best->duration) best = std::move(plan);
    }
  }
  if (best) return std::move(*best);
  std::string text = fmt::format("of {} grips none leads to the goal; the best fails at {}",
                                 grips.size(), Furthest());
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    const auto count = std::ranges::count(trials_, static_cast<Leg>(leg), &Trial::leg);
    if (count > 0)
      text += fmt::format("; {} of the grips fail at \"{}\"", count, kLegTraits[leg].name);
  }
  return text;
}

OrReason<PickPlan> PickPlanner::PlanFrom(const JointVector& q, Leg first, const Grip& grip) {
  trials_.assign(1, {});
  grip_ = 0;
  checks_left_ = options_.budget;
  PickPlan plan{.grip = grip, .legs = {}};
  for (const bool samples : {false, true}) {
    samples_ = samples;
    if (!Search(q, first, plan)) continue;
    plan.duration = DurationOf(plan);
    return plan;
  }
  return Furthest();
}

OrReason<LegPlan> PickPlanner::BackOff(const JointVector& q, const Grip& grip) {
  SetWorld(kGrasp, grip);
  const Vector3d up = options_.above * Vector3d(task_.from_up.data());
  return Try({kStraight, {MovedBy(PoseAt(q), up)}}, q, options_.pace, options_.near);
}

}  // namespace twin::application

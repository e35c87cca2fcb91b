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

namespace twin::application {
namespace {

using Eigen::Vector3d;

constexpr double kSamePose = 1e-4;  // m and rad
constexpr double kHigher = 0.12;    // m, height of intermediate points
constexpr double kNearer = 0.75;    // share of the distance from the robot, of nearer points
constexpr int kSlowings = 4;

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
                         const Transform& F_T_EE, PickTask task, const PickOptions& options)
    : world_(world), robot_(robot), F_T_EE_(F_T_EE), task_(std::move(task)), options_(options) {}

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
      return {{above_object},
              {MovedBy(above_object, higher), above_object},
              {MovedBy(here, higher), MovedBy(above_object, higher), above_object}};
    case kGrasp: return {{at_object}};
    case kLift: return {{above_object}};
    case kTransfer: {
      const double rise = std::max(0.0, above_goal[14] - here[14]);
      const Transform risen = MovedBy(here, Vector3d(0, 0, rise));
      return {{above_goal},
              {risen, above_goal},
              {Between(here, above_goal), above_goal},
              {MovedBy(risen, higher), MovedBy(above_goal, higher), above_goal},
              {risen, Between(risen, above_goal), above_goal}};
    }
    case kPlace: return {{at_goal}};
    case kRetreat: {
      const Vector3d away =
          model::Orientation(task_.O_T_goal) * Vector3d(grip.B_up.data()) * options_.above;
      return {{MovedBy(at_goal, away)}};
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
    if (leg == kLift) world_.Allow(name, task_.from);
    if (leg == kPlace) world_.Allow(name, task_.to);
  } else {
    world_.Place(name, leg == kRetreat ? task_.O_T_goal : task_.object.X_WB);
  }
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
  for (const Transform& pose : route) {
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

bool PickPlanner::Search(const JointVector& q, Leg leg, PickPlan& plan) {
  if (leg == kLegs) {
    plan.duration = {};
    for (const LegPlan& leg : plan.legs) plan.duration += leg.duration;
    return true;
  }
  const bool is_across = leg == kApproach || leg == kTransfer;
  const bool is_down = leg == kGrasp || leg == kPlace;
  for (const Route& route : RoutesOf(leg, PoseAt(q), plan.grip)) {
    SetWorld(leg, plan.grip);
    auto tried = Try(route, q, is_down ? options_.down_pace : options_.pace,
                     is_across ? options_.clearance : options_.near);
    if (const auto* why = std::get_if<std::string>(&tried)) {
      if (failure_.empty() || leg > furthest_) {
        furthest_ = leg;
        failure_ = *why;
      }
      continue;
    }
    plan.legs[leg] = std::move(std::get<LegPlan>(tried));
    if (Search(plan.legs[leg].q_end, static_cast<Leg>(leg + 1), plan)) return true;
  }
  return false;
}

OrReason<PickPlan> PickPlanner::Plan(const JointVector& q) {
  furthest_ = kApproach;
  failure_.clear();
  const std::vector<Grip> grips = GripsOf(task_.object, task_.from_up,
                                          {.palm = options_.clearance + 2e-3,
                                           .below = options_.near + 3e-3,
                                           .beside = options_.near + 1e-3});
  if (grips.empty()) {
    return fmt::format(
        "{} ({} x {} x {} m) cannot be gripped from above: it is too wide for the hand, which "
        "opens by {} m, or too flat",
        task_.object.name, task_.object.size[0], task_.object.size[1], task_.object.size[2],
        kHandStroke);
  }
  std::optional<PickPlan> best;
  for (const Grip& grip : grips) {
    PickPlan plan{.grip = grip, .legs = {}};
    if (!Search(q, kApproach, plan) || (best && best->duration <= plan.duration)) continue;
    best = std::move(plan);
  }
  if (best) return std::move(*best);
  return fmt::format("of {} grips none leads to the goal; the best fails at the way \"{}\": {}",
                     grips.size(), kLegTraits[furthest_].name, failure_);
}

OrReason<PickPlan> PickPlanner::PlanFrom(const JointVector& q, Leg first, const Grip& grip) {
  furthest_ = kApproach;
  failure_.clear();
  PickPlan plan{.grip = grip, .legs = {}};
  if (Search(q, first, plan)) return plan;
  return fmt::format("the way \"{}\": {}", kLegTraits[furthest_].name, failure_);
}

OrReason<LegPlan> PickPlanner::BackOff(const JointVector& q, const Grip& grip) {
  SetWorld(kGrasp, grip);
  return Try({MovedBy(PoseAt(q), options_.above * Vector3d(task_.from_up.data()))}, q,
             options_.pace, options_.near);
}

}  // namespace twin::application

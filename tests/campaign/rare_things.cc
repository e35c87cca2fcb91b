#include "campaign/rare_things.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <variant>

#include <fmt/format.h>

#include "twin/plant/perturbation.h"

namespace twin::campaign {
namespace {

using control::CommandInterface;
using scenario::Scenario;
using test::Dice;

/// A law of friction that is stable at 1 kHz with the rotors' inertia.
plant::FrictionLaw DrawFriction(Dice& dice) {
  plant::FrictionLaw law;
  for (std::size_t i = 0; i < kJoints; ++i) {
    law.viscous[i] = dice.Between(0, 2);
    law.coulomb[i] = dice.Between(0, 0.5);
    law.offset[i] = dice.Between(-0.2, 0.2);
    law.steepness[i] = dice.Between(10, 200);
    law.shift[i] = dice.Between(-0.1, 0.1);
  }
  return law;
}

/// What is this arm's own, and how it stands.
void DrawArm(Dice& dice, Scenario& world) {
  if (world.plant.kind == robot::PlantKind::kIdeal) return;
  if (dice.Chance(0.15)) {
    world.plant.elasticity = plant::ElasticityProfile::kStatic;
    for (double& k : world.plant.arm.stiffness) k *= dice.Between(0.5, 2);
  }
  if (world.plant.armature && dice.Chance(0.1)) {
    world.plant.arm.armature = plant::kArmature;
    for (double& b : *world.plant.arm.armature) b *= dice.Between(0.7, 1.5);
  }
  if (world.plant.armature && dice.Chance(0.1)) {
    world.plant.friction = scenario::PlantSection().friction;  // a scenario says profile or law
    world.plant.arm.friction_law = DrawFriction(dice);
  }
  if (dice.Chance(0.1)) {
    world.plant.arm.torque_delay = std::chrono::microseconds(dice.Whole(0, 5000));
  }
  if (dice.Chance(0.1) && !world.base) {
    world.plant.base_tilt = {dice.Between(-0.1, 0.1), dice.Between(-0.1, 0.1)};
  }
}

/// Someone takes the hand and leads it, and pushes are no longer through a body's centre.
void DrawHands(Dice& dice, Scenario& world) {
  for (plant::Perturbation& perturbation : world.perturbations) {
    auto* const push = std::get_if<plant::Push>(&perturbation);
    if (push == nullptr || !dice.Chance(0.3)) continue;  // a user's spring stays
    for (double& moment : push->torque) moment = dice.Between(-10, 10);
    for (double& p : push->point) p = dice.Between(-0.1, 0.1);
    if (dice.Chance(0.5)) push->frame = plant::ForceFrame::kBody;
    if (dice.Chance(0.5)) push->motion = 1;
  }
  if (world.plant.kind == robot::PlantKind::kIdeal || !dice.Chance(0.1)) return;
  plant::HandSpring spring{.body = fmt::format("panda_link{}", dice.Whole(4, 7))};
  spring.begin = std::chrono::milliseconds(dice.Whole(0, 1000));
  spring.duration = std::chrono::milliseconds(dice.Whole(200, 1500));
  for (double& by : spring.by) by = dice.Between(-0.1, 0.1);
  spring.stiffness = dice.Between(100, 3000);
  spring.largest_force = dice.Between(5, 60);
  world.perturbations.emplace_back(spring);
}

/// Of INT and the chain, what clients seldom change.
void DrawSettings(Dice& dice, Scenario& world) {
  scenario::OnboardSection& onboard = world.onboard;
  if (dice.Chance(0.2)) {
    for (double& K : onboard.K_x) K *= dice.Between(0.1, 1);
  }
  if (dice.Chance(0.1)) {
    onboard.EE_T_K = {{0, 0, dice.Between(-0.1, 0.1)}, {dice.Between(-1, 1), 0, 0}};
  }
  if (dice.Chance(0.1)) {
    setting::CollisionBehavior& behavior = onboard.collision_behavior;
    const double lower = dice.Between(0.1, 1);
    behavior = {};
    for (double& tau : behavior.lower_torque_acc) tau *= lower;
    for (double& tau : behavior.lower_torque_nominal) tau *= lower;
    for (double& f : behavior.lower_force_acc) f *= lower;
    for (double& f : behavior.lower_force_nominal) f *= lower;
  }
  if (dice.Chance(0.1)) onboard.abort_after_lost = static_cast<std::uint32_t>(dice.Whole(1, 40));
  if (dice.Chance(0.1)) {
    for (bool& axis : onboard.guiding_mode.axes) axis = dice.Chance(0.5);
    onboard.guiding_mode.elbow = dice.Chance(0.5);
  }
  if (dice.Chance(0.1)) world.tick.low_pass_hz = dice.Between(20, 1000);
  if (dice.Chance(0.1)) {
    world.robot.q_start = world.motion.waypoints.front().q;
    for (double& q : *world.robot.q_start) q += dice.Between(-5e-4, 5e-4);
  }
}

/// Limits that a lab demands, most of them too far away to be met.
void DrawLimits(Dice& dice, Scenario& world) {
  if (!dice.Chance(0.12)) return;
  model::LabLimits& limits = world.limits;
  if (dice.Chance(0.3)) limits.v_max = dice.Between(0.2, 1.7);
  if (dice.Chance(0.3)) limits.w_max = dice.Between(0.5, 2.5);
  if (dice.Chance(0.3)) limits.dq_max.emplace().fill(dice.Between(0.3, 2));
  if (dice.Chance(0.3)) limits.force_max = dice.Between(5, 100);
  if (dice.Chance(0.3)) limits.tau_max.emplace().fill(dice.Between(5, 60));
  if (dice.Chance(0.4)) {
    limits.regions.push_back(
        {.name = "room", .shape = model::LimitBox{{-1, -1, -1}, {1, 1, dice.Between(0.7, 1.3)}}});
  }
  if (dice.Chance(0.4)) {
    limits.regions.push_back(
        {.name = "wall",
         .shape = model::HalfSpace{{dice.Between(-1, 1), 1, 0}, dice.Between(0.2, 0.8)}});
  }
  if (dice.Chance(0.2)) {
    limits.regions.push_back({.name = "pillar",
                              .keep_inside = false,
                              .shape = model::LimitBox{{0.5, 0.2, 0}, {0.7, 0.4, 0.6}}});
  }
}

/// Another controller than the path's, where the interface has one.
void DrawController(Dice& dice, Scenario& world) {
  if (!dice.Chance(0.15)) return;
  scenario::MotionSection& motion = world.motion;
  switch (motion.interface) {
    case CommandInterface::kJointPosition:
      if (dice.Chance(0.3)) {
        world.controller.type = "joint_position";
        return;
      }
      world.controller.type = "cartesian_pose";
      motion.waypoints = {{.q = kReady}};
      for (int i = dice.Whole(1, 3); i > 0; --i) {
        scenario::PoseStep step;
        for (double& by : step.by) by = dice.Between(-0.1, 0.1);
        for (double& turn : step.turn) turn = dice.Between(-0.3, 0.3);
        motion.poses.push_back(step);
      }
      world.robot.q_start.reset();
      return;
    case CommandInterface::kJointVelocity: world.controller.type = "joint_velocity"; return;
    case CommandInterface::kTorque:
      world.controller.type = dice.Chance(0.5) ? "compliance" : "gravity_hold";
      return;
    case CommandInterface::kCartesianPose: return;
  }
}

/// The arm rides on a base that drives.
void DrawBase(Dice& dice, Scenario& world) {
  if (world.plant.kind == robot::PlantKind::kIdeal || !dice.Chance(0.06)) return;
  world.plant.base_tilt = {};
  scenario::BaseSection& base = world.base.emplace();
  int at = dice.Whole(0, 500);
  for (int i = dice.Whole(1, 3); i > 0; --i) {
    const int span = dice.Whole(50, 1000);
    base.drive.push_back({std::chrono::milliseconds(at),
                          std::chrono::milliseconds(span),
                          {dice.Between(-0.8, 0.8), dice.Between(-0.8, 0.8)}});
    at += span + dice.Whole(1, 300);
  }
}

/// Something between the fingers, which close on it where the motion begins.
void DrawObject(Dice& dice, Scenario& world) {
  const bool has_hand = world.robot.hand != plant::HandKind::kNone;
  if (world.plant.kind == robot::PlantKind::kIdeal || !has_hand || !dice.Chance(0.08)) return;
  world.motion.waypoints.front().q = kReady;
  world.robot.q_start.reset();
  const double width = dice.Between(0.01, 0.07);
  scenario::ObjectSection object{.name = "part", .size = {0.02, width, 0.04}};
  object.pose.position = {0.3069, 0, 0.487};  // of the fingertips there
  if (dice.Chance(0.7)) object.mass = dice.Between(0.02, 0.5);
  object.friction = dice.Between(0.1, 1.5);
  world.objects.push_back(object);
  const auto now = std::chrono::milliseconds(dice.Whole(0, 20));
  world.hand = {{now, hand::Grasp{.width = width * dice.Between(0.7, 1.3),
                                  .speed = 0.2,
                                  .force = dice.Between(1, 100)}}};
  if (dice.Chance(0.3)) {
    world.hand.push_back({now + std::chrono::milliseconds(dice.Whole(1, 1500)),
                          hand::Move{dice.Between(0, 0.08), dice.Between(0.01, 0.2)}});
  }
}

/// A pump on the flange, and below its cup a part on a stand.
void DrawPump(Dice& dice, Scenario& world) {
  if (world.plant.kind == robot::PlantKind::kIdeal || world.base || !dice.Chance(0.06)) return;
  world.robot.hand = plant::HandKind::kCobotPump;
  world.motion.waypoints.front().q = kReady;
  world.robot.q_start.reset();
  world.objects.clear();
  constexpr double kCup = 0.4853;  // height of its face there, m
  const double height = dice.Between(0.02, 0.1);
  scenario::ObjectSection part{.name = "part", .size = {0.1, 0.1, height}};
  part.mass = dice.Between(0.05, 2);
  part.pose.position = {0.3069, 0, kCup - height / 2 - dice.Between(0, 0.002)};
  scenario::ObjectSection stand{.name = "stand", .size = {0.1, 0.1, 0.1}};
  stand.pose.position = part.pose.position;
  stand.pose.position[2] -= height / 2 + 0.05;
  world.objects = {stand, part};
  world.hand.clear();
  int at = dice.Whole(0, 20);
  for (int i = dice.Whole(1, 4); i > 0; --i) {
    HandCommand command = hand::Vacuum{.vacuum = static_cast<std::uint8_t>(dice.Whole(1, 80)),
                                       .profile = static_cast<std::uint8_t>(dice.Whole(0, 3)),
                                       .timeout_ms = dice.Whole(0, 1000)};
    const int kind = dice.Whole(0, 3);
    if (kind == 1) command = hand::DropOff{dice.Whole(0, 1000)};
    if (kind == 2) command = hand::Stop{};
    world.hand.push_back({std::chrono::milliseconds(at), command});
    at += dice.Whole(1, 600);
  }
}

/// A controller that now and then computes for so long that it counts as stalled.
void DrawSilence(Dice& dice, Scenario& world) {
  if (world.loop == loop::LoopKind::kBare || !dice.Chance(0.1)) return;
  const double usual_s = 60e-6;
  const double silent_s = dice.Between(2, 8) / world.controller.rate_hz +
                          ToSeconds(world.tick.stall_time) * dice.Between(0.5, 2);
  world.controller.cost = {faults::EmpiricalDelay{
      {FromSeconds(usual_s), FromSeconds(2 * usual_s), FromSeconds(silent_s)},
      {1, dice.Between(0.002, 0.05)}}};
}

/// As many losses in a row as the filter is made for, again and again, so that some come where the
/// reference is at a limit.
void DrawLongestLosses(Scenario& world) {
  Dice dice(~world.seed);
  if (!world.tick.viability || !dice.Chance(0.15)) return;
  const int count = std::min(*world.tick.viability, 19);  // of more the motion ends
  if (count == 0) return;
  scenario::ScriptedLoss script;
  int at = dice.Whole(5, 300);
  for (int i = dice.Whole(10, 100); i > 0; --i) {
    script.bursts.push_back({std::chrono::milliseconds(at), static_cast<std::uint64_t>(count)});
    at += count + dice.Whole(2, 60);
  }
  world.link.state.loss = {};
  world.link.command.loss = {script};
}

/// What takes an arm off its way, or INT does not know.
void TakeDisturbancesAway(Scenario& world) {
  const scenario::OnboardSection usual;
  world.plant = {};
  world.link = {};
  world.robot.load = world.onboard.load;
  world.onboard.K_theta = usual.K_theta;
  world.onboard.K_x = usual.K_x;
  world.perturbations.clear();
  world.panel.clear();
}

/// A motion that is planned around boxes on its way; in most of these worlds it must not touch
/// them.
void DrawPlan(Scenario& world) {
  Dice dice(~world.seed ^ (std::uint64_t{1} << 50));
  const bool is_plain = world.motion.interface == CommandInterface::kJointPosition &&
                        world.motion.poses.empty() && world.controller.type == "joint_trajectory";
  if (!is_plain || world.base || !world.objects.empty() || !dice.Chance(0.15)) return;
  world.hand.clear();  // its plan takes the hand to stay as it is
  world.robot.q_start = kReady;
  world.motion.waypoints.clear();
  world.motion.touches.clear();
  scenario::PlanSection& plan = world.motion.plan.emplace();
  plan.budget = 20'000;
  plan.clearance = dice.Between(0.01, 0.05);
  if (dice.Chance(0.7)) TakeDisturbancesAway(world);
  for (int i = dice.Whole(0, 6); i > 0; --i) {
    scenario::ObjectSection box{.name = fmt::format("box{}", i)};
    for (double& side : box.size) side = dice.Between(0.05, 0.3);
    const double angle = dice.Between(-3, 3);
    const double away = dice.Between(0.3, 0.7);
    box.pose.position = {away * std::cos(angle), away * std::sin(angle), dice.Between(0.2, 0.9)};
    world.objects.push_back(box);
  }
}

}  // namespace

void DrawRareThings(Dice& dice, Scenario& world, bool all) {
  DrawArm(dice, world);
  DrawHands(dice, world);
  if (!all) return;
  DrawSettings(dice, world);
  DrawLimits(dice, world);
  DrawController(dice, world);
  DrawBase(dice, world);
  DrawObject(dice, world);
  DrawSilence(dice, world);
  if (world.robot.model == "panda") DrawPump(dice, world);
  DrawLongestLosses(world);
  DrawPlan(world);
}

}  // namespace twin::campaign

#include "campaign/world.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>

#include <fmt/format.h>

#include "campaign/rare_things.h"
#include "conformance/dice.h"

namespace twin::campaign {
namespace {

using control::CommandInterface;
using scenario::Scenario;
using test::Dice;

Duration Microseconds(double us) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(us));
}

/// A law with about this typical value.
scenario::Delay DrawDelay(Dice& dice, double typical_us) {
  const double us = typical_us * dice.Between(0.2, 2);
  switch (dice.Whole(0, 4)) {
    case 0: return {faults::ConstantDelay{Microseconds(us)}};
    case 1: return {faults::LogNormalDelay{Microseconds(us), dice.Between(0, 1), Microseconds(5)}};
    case 2: return {faults::NormalDelay{Microseconds(us), Microseconds(us * dice.Between(0, 1))}};
    case 3: return {faults::GammaDelay{dice.Between(0.3, 3), Microseconds(us), Duration::zero()}};
    default:
      return {
          faults::EmpiricalDelay{{Microseconds(us), Microseconds(2 * us), Microseconds(20 * us)},
                                 {1, dice.Between(0, 0.05)}}};
  }
}

scenario::Loss DrawLoss(Dice& dice) {
  switch (dice.Whole(0, 3)) {
    case 0: return {scenario::IndependentLoss{dice.Between(0, 10)}};
    case 1:
      return {scenario::GilbertElliottLoss{.good_to_bad = dice.Between(0, 2),
                                           .bad_to_good = dice.Between(5, 100),
                                           .loss_good = 0,
                                           .loss_bad = dice.Between(50, 100)}};
    default: {
      scenario::ScriptedLoss script;
      int at = dice.Whole(5, 300);
      for (int i = dice.Whole(1, 4); i > 0; --i) {
        const int count = dice.Whole(1, 21);
        script.bursts.push_back({std::chrono::milliseconds(at), static_cast<std::uint64_t>(count)});
        at += count + dice.Whole(1, 400);
      }
      return {script};
    }
  }
}

scenario::DirectionSection DrawDirection(Dice& dice) {
  scenario::DirectionSection direction;
  direction.delay = DrawDelay(dice, dice.Chance(0.1) ? 800 : 60);
  if (dice.Chance(0.4)) direction.loss = DrawLoss(dice);
  if (dice.Chance(0.1)) direction.duplication = {dice.Between(0, 20), DrawDelay(dice, 300)};
  if (dice.Chance(0.1)) {
    direction.reordering = {dice.Between(0, 10), Microseconds(dice.Between(100, 3000))};
  }
  return direction;
}

/// What is about the workstation's own software.
void DrawSurroundings(Dice& dice, Scenario& world) {
  world.link.state = DrawDirection(dice);
  world.link.command = DrawDirection(dice);
  world.link.d_INT = Microseconds(dice.Between(0, 400));
  if (dice.Chance(0.3)) world.robot.clock_drift_ppm = dice.Between(-1000, 1000);
  world.tick.cost = DrawDelay(dice, 15);
  if (world.loop == loop::LoopKind::kBare) return;  // without a clock of the workstation
  if (dice.Chance(0.3)) world.controller.clock_drift_ppm = dice.Between(-1000, 1000);
  world.controller.phase = Microseconds(dice.Between(0, 1000));
  world.controller.wake_delay = DrawDelay(dice, 30);
  world.controller.cost = DrawDelay(dice, dice.Chance(0.1) ? 600 : 60);
}

void DrawPlant(Dice& dice, Scenario& world) {
  const bool is_ideal = dice.Chance(0.5);
  // A user's scenario may have what only MuJoCo's plant feels.
  if (is_ideal && world.perturbations.empty() && world.objects.empty()) {
    world.plant.kind = robot::PlantKind::kIdeal;
    return;
  }
  world.plant.kind = robot::PlantKind::kMujoco;
  world.plant.friction = static_cast<plant::FrictionProfile>(dice.Whole(0, 2));
  world.plant.armature = dice.Chance(0.7);
  // Without its rotors' inertia a wrist is too light at 1 kHz: an FR3's for INT's stiffness, a
  // Panda's for the damping of its Cartesian impedance (world 7138).
  if (world.robot.model == "fr3" ||
      world.motion.controller == ControllerMode::kCartesianImpedance) {
    world.plant.armature = true;
  }
  if (dice.Chance(0.2)) world.plant.mass_scale = dice.Between(0.9, 1.1);
  if (dice.Chance(0.3)) {
    world.plant.noise_q = dice.Between(0, 2e-5);
    world.plant.noise_dq = dice.Between(0, 2e-3);
    world.plant.noise_tau_J = dice.Between(0, 0.1);
  }
  if (dice.Chance(0.3)) {
    setting::Load& load = world.robot.load;
    load.m_load = dice.Between(0.01, 3);
    load.F_x_Cload = {dice.Between(-0.05, 0.05), dice.Between(-0.05, 0.05), dice.Between(0, 0.15)};
    for (const std::size_t i : {0U, 4U, 8U}) load.I_load[i] = load.m_load * 0.004;
    if (dice.Chance(0.8)) world.onboard.load = load;
  }
}

void DrawOnboard(Dice& dice, Scenario& world) {
  if (dice.Chance(0.5)) world.onboard.collision_behavior = scenario::NoCollisionBehavior();
  if (dice.Chance(0.2)) {
    for (double& K : world.onboard.K_theta) K *= dice.Between(0.1, 1);
  }
  if (dice.Chance(0.1)) {
    world.onboard.filters.joint_position_hz = dice.Between(50, 1000);
    world.onboard.filters.joint_velocity_hz = dice.Between(50, 1000);
    world.onboard.filters.cartesian_position_hz = dice.Between(50, 1000);
    world.onboard.filters.controller_hz = dice.Between(50, 1000);
  }
  if (dice.Chance(0.1)) world.onboard.damping_ratio = dice.Between(0.3, 1.5);
  if (dice.Chance(0.1)) world.onboard.friction_compensation = dice.Between(0, 1);
  if (dice.Chance(0.1)) {
    world.onboard.NE_T_EE = {{0, 0, dice.Between(0, 0.1)}, {0, 0, dice.Between(-1, 1)}};
  }
}

void DrawMotion(Dice& dice, Scenario& world) {
  static constexpr std::array kInterfaces{
      CommandInterface::kJointPosition, CommandInterface::kJointPosition,
      CommandInterface::kJointVelocity, CommandInterface::kCartesianPose,
      CommandInterface::kTorque};
  scenario::MotionSection& motion = world.motion;
  motion.interface = kInterfaces[static_cast<std::size_t>(dice.Whole(0, 4))];
  const bool is_torque = motion.interface == CommandInterface::kTorque;
  if (!is_torque && dice.Chance(0.2)) motion.controller = ControllerMode::kCartesianImpedance;
  // An FR3 comes so near to the ends of its range that its velocity limits shrink.
  const double reach = world.robot.model == "fr3" ? 0.65 : 0.3;
  motion.touches = "a world of the campaign moves wherever it likes";
  for (int i = dice.Whole(2, 4); i > 0; --i) {
    reference::Waypoint point{.q = kReady};
    for (double& q : point.q) q += dice.Between(-reach, reach);
    point.stop = dice.Chance(0.2);
    motion.waypoints.push_back(point);
  }
  motion.timing = {.duration = {},
                   .velocity_scale = dice.Between(0.1, 1),
                   .acceleration_scale = dice.Between(0.05, 0.9),
                   .jerk_scale = dice.Between(0.05, 0.9)};
}

loop::Generator DrawGenerator(Dice& dice, CommandInterface interface) {
  if (dice.Chance(0.6)) return loop::Generator::kRejoining;
  if (dice.Chance(0.4)) return loop::Generator::kNone;
  return interface == CommandInterface::kCartesianPose ? loop::Generator::kCartesian
                                                       : loop::Generator::kJoint;
}

void DrawLoop(Dice& dice, Scenario& world) {
  const double kind = dice.Uniform();
  world.loop = kind < 0.7    ? loop::LoopKind::kAsynchronous
               : kind < 0.85 ? loop::LoopKind::kSynchronous
                             : loop::LoopKind::kBare;
  scenario::TickSection& tick = world.tick;
  const CommandInterface interface = world.motion.interface;
  if (interface == CommandInterface::kTorque) {
    world.controller.type = "joint_trajectory_effort";
    tick = scenario::TorqueTick();
    tick.limiter = dice.Chance(0.7);
  } else {
    tick.generator = DrawGenerator(dice, interface);
    if (!loop::Misfit(tick.generator, interface).empty()) tick.generator = loop::Generator::kNone;
    tick.viability.reset();
    if (dice.Chance(0.7)) tick.viability = dice.Whole(0, 25);
    tick.limiter = dice.Chance(0.1);
    tick.rate_matching = dice.Chance(0.7);
  }
  if (world.loop == loop::LoopKind::kAsynchronous && dice.Chance(0.1)) {
    tick.period_tolerance = Microseconds(dice.Between(100, 900));
  }
  if (dice.Chance(0.2)) tick.stall_time = std::chrono::milliseconds(dice.Whole(1, 60));
  if (dice.Chance(0.1)) tick.lambda = dice.Between(1e-4, 1e-2);
  if (world.loop == loop::LoopKind::kAsynchronous && dice.Chance(0.3)) {
    world.controller.rate_hz = dice.Chance(0.5) ? 100 * dice.Whole(1, 10) : dice.Between(20, 1000);
  }
  if (dice.Chance(0.1)) {
    world.controller.target_noise = dice.Between(0, 1e-6);
  }
  if (dice.Chance(0.3)) {
    world.controller.feed_forward = static_cast<reference::FeedForwardTime>(dice.Whole(0, 1));
  }
}

void DrawPushes(Dice& dice, Scenario& world) {
  if (world.plant.kind == robot::PlantKind::kIdeal || !dice.Chance(0.25)) return;
  for (int i = dice.Whole(1, 3); i > 0; --i) {
    plant::Push push{.body = fmt::format("panda_link{}", dice.Whole(2, 7))};
    push.begin = std::chrono::milliseconds(dice.Whole(0, 2000));
    push.duration = std::chrono::milliseconds(dice.Whole(10, 800));
    push.rise = push.duration / 3;
    for (double& f : push.force) f = dice.Between(-60, 60);
    world.perturbations.emplace_back(push);
  }
}

void DrawPeople(Dice& dice, Scenario& world) {
  if (dice.Chance(0.15)) {
    int at = dice.Whole(0, 1500);
    for (int i = dice.Whole(1, 4); i > 0; --i) {
      world.panel.push_back({std::chrono::milliseconds(at),
                             static_cast<PanelAction>(dice.Whole(0, kPanelActions - 1))});
      at += dice.Whole(0, 500);
    }
  }
  if (world.robot.hand == plant::HandKind::kNone || !dice.Chance(0.15)) return;
  int at = dice.Whole(0, 100);  // before the shortest motions end
  for (int i = dice.Whole(1, 3); i > 0; --i) {
    HandCommand command = hand::Homing{};
    const int kind = dice.Whole(0, 3);
    if (kind == 1) command = hand::Move{dice.Between(0, 0.08), dice.Between(0.01, 0.2)};
    if (kind == 2) {
      command =
          hand::Grasp{.width = dice.Between(0, 0.08), .speed = 0.1, .force = dice.Between(1, 100)};
    }
    if (kind == 3) command = hand::Stop{};
    world.hand.push_back({std::chrono::milliseconds(at), command});
    at += dice.Whole(1, 150);
  }
}

bool IsFr3World(std::uint64_t seed) {
  return seed % 13 == 6;
}

}  // namespace

Scenario DrawWorld(std::uint64_t seed, const Scenario* around) {
  Dice dice(seed);
  Scenario world = around != nullptr ? *around : Scenario();
  world.name = fmt::format("world_{}", seed);
  world.description = fmt::format("World {} of the reliability campaign.", seed);
  world.seed = seed;
  world.render.enabled = false;
  world.drive = scenario::Drive::kLockstep;
  if (around == nullptr) {
    world.scene = "scenes/floor.xml";
    if (dice.Chance(0.3)) world.robot.hand = plant::HandKind::kNone;
    if (IsFr3World(seed)) world.robot.model = "fr3";
    DrawMotion(dice, world);
    DrawLoop(dice, world);
    DrawOnboard(dice, world);
    DrawPeople(dice, world);
  }
  DrawPlant(dice, world);
  DrawSurroundings(dice, world);
  DrawPushes(dice, world);
  DrawRareThings(dice, world, around == nullptr);
  if (around == nullptr && world.tick.generator == loop::Generator::kRejoining) {
    // It is refused behind a low-pass.
    world.tick.low_pass_hz = scenario::TickSection().low_pass_hz;
    world.onboard.filters = {.controller_hz = world.onboard.filters.controller_hz};
  }
  return world;
}

}  // namespace twin::campaign

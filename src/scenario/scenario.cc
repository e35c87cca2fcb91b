#include "twin/scenario/scenario.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "twin/core/error.h"

namespace twin::scenario {
namespace {

/// A threshold no force reaches: the largest that INT takes, N or Nm.
constexpr double kUnreachable = 1e6;

void RefuseIf(bool wrong, const char* why) {
  if (wrong) throw InputError(why);
}

/// The synchronous loop sleeps on its own clock and the bare one is the robot's: they have no time
/// by which a state could be out of order, and the bare loop has no clock at all.
void ValidateLoop(const Scenario& scenario) {
  const ControllerSection& controller = scenario.controller;
  RefuseIf(scenario.loop != loop::LoopKind::kAsynchronous &&
               scenario.tick.period_tolerance != Duration::zero(),
           "tick.period_tolerance: only the asynchronous loop has one; leave it out, or say loop: "
           "asynchronous");
  const bool has_clock = controller.rate_hz != 1000 || controller.clock_drift_ppm != 0 ||
                         controller.phase != Duration::zero() || controller.wake_delay != Delay();
  RefuseIf(scenario.loop == loop::LoopKind::kBare && has_clock,
           "controller: the bare loop is paced by the robot, at 1000 Hz; rate, clock_drift, phase "
           "and wake_delay have no meaning in it: leave them out, or say loop: asynchronous");
}

void ValidatePlant(const Scenario& scenario) {
  const PlantSection& plant = scenario.plant;
  try {
    plant::Validate(plant.arm, plant.armature);
  } catch (const InputError& error) {
    throw InputError(fmt::format("plant.{}", error.what()));
  }
  if (plant.kind != robot::PlantKind::kIdeal) return;
  RefuseIf(
      plant.mass_scale != 1 || !(plant.base_tilt == plant::BaseTilt()) ||
          !plant.arm.links.empty() || plant.arm.friction_law ||
          plant.arm.torque_delay != Duration::zero(),
      "plant: the ideal plant does what INT wants, whatever it weighs and however it stands; "
      "leave mass_scale, base_tilt, links, delay and a law of friction out, or say kind: mujoco");
  RefuseIf(!scenario.perturbations.empty(),
           "perturbations: the ideal plant feels no forces; say plant: {kind: mujoco}, or leave "
           "them out");
}

/// A mobile base rolls in the engine, and only a run's own motion may stand on one.
void ValidateBase(const Scenario& scenario) {
  if (!scenario.base) return;
  RefuseIf(scenario.is_remote(),
           "base: a robot at the other end of a wire has none; say backend: mujoco, or leave base "
           "out");
  RefuseIf(scenario.plant.kind == robot::PlantKind::kIdeal,
           "base: the ideal plant has no wheels; say plant: {kind: mujoco}, or leave base out");
  RefuseIf(!(scenario.plant.base_tilt == plant::BaseTilt()),
           "base: it stands as its tyres let it; leave plant.base_tilt out, or leave base out");
  RefuseIf(scenario.motion.plan.has_value(),
           "base: a motion is planned for an arm that stands on the world; give a trajectory or "
           "poses, or leave base out");
  RefuseIf(scenario.application && !scenario.base->drive.empty(),
           "base.drive: beside an application, which drives the base itself");
}

void ValidatePose(const Scenario& scenario) {
  if (scenario.robot.pose == plant::ArmPose()) return;
  RefuseIf(scenario.base.has_value(),
           "robot.pose: the arm stands on a mobile base; say base.start, or leave one of them out");
}

void ValidateHand(const Scenario& scenario) {
  if (scenario.hand.empty()) return;
  RefuseIf(scenario.robot.hand == plant::HandKind::kNone,
           "hand: robot.hand is none, so there is nothing to command; say robot: {hand: "
           "franka_hand}, or {hand: cobot_pump} to suck, or leave the commands out");
  const HandDevice device = plant::DeviceOf(scenario.robot.hand);
  for (const HandEvent& event : scenario.hand) {
    if (const auto bad = FindBadValue(event.command, 0, device)) {
      throw InputError(fmt::format("hand: at {}: {}: {}", FormatDuration(event.at),
                                   twin::Name(event.command), twin::Describe(*bad)));
    }
  }
  RefuseIf(scenario.application.has_value(),
           "hand: beside an application, which commands the hand itself");
  RefuseIf(scenario.motion.plan.has_value(),
           "motion.plan: it takes the hand to stay as it is; leave the commands to the hand out");
}

/// What is planned has no points but its ends, and only shares of the limits for its pace.
void ValidatePlan(const Scenario& scenario) {
  const MotionSection& motion = scenario.motion;
  RefuseIf(!motion.waypoints.empty() || !motion.poses.empty(),
           "motion.plan: waypoints or poses beside it; a motion has one of trajectory, poses, "
           "plan");
  RefuseIf(!scenario.robot.q_start,
           "motion.plan: it begins at robot.q_start, which is not given; give it, as robot: "
           "{q_start: {unit: rad, values: [...]}}");
  RefuseIf(motion.timing.duration.has_value(),
           "motion.plan: a duration cannot be asked for; give shares of the limits, or stretch");
}

void ValidateMotion(const Scenario& scenario) {
  const MotionSection& motion = scenario.motion;
  if (motion.plan) return ValidatePlan(scenario);
  const std::size_t count = motion.waypoints.size();
  if (!motion.poses.empty() && count != 1) {
    throw InputError(
        fmt::format("motion.poses: {} points through joint space beside them; give one, where the "
                    "arm begins",
                    count));
  }
  if (motion.poses.empty() && count < 2) {
    throw InputError(
        fmt::format("motion.trajectory: {} waypoints; a trajectory needs at least two", count));
  }
}

/// It begins where the robot stands, and makes its motions itself.
void ValidateApplication(const Scenario& scenario) {
  const MotionSection& motion = scenario.motion;
  RefuseIf(!motion.waypoints.empty() || !motion.poses.empty() || motion.plan,
           "motion: beside an application, which makes its motions itself");
  RefuseIf(!scenario.robot.q_start,
           "application: it begins at robot.q_start, which is not given; give it, as robot: "
           "{q_start: {unit: rad, values: [...]}}");
}

bool SamePoint(const reference::Waypoint& a, const reference::Waypoint& b) {
  return a.q == b.q && a.at == b.at && a.stop == b.stop;
}

}  // namespace

std::string_view Name(Drive drive) noexcept {
  return NameOf(kDriveNames, drive);
}

Drive DriveFromName(std::string_view name) {
  for (const auto& [spelling, drive] : kDriveNames) {
    if (spelling == name) return drive;
  }
  if (name == "remote") {
    throw InputError(
        "drive \"remote\" repeats backend fci: write backend: fci and no drive, or without that "
        "backend realtime or lockstep");
  }
  throw InputError(
      fmt::format("drive \"{}\" is unknown; accepted: lockstep (the virtual clock), realtime (the "
                  "wall clock)",
                  name));
}

Transform FramePose::Matrix() const noexcept {
  const double cr = std::cos(rpy[0]);
  const double sr = std::sin(rpy[0]);
  const double cp = std::cos(rpy[1]);
  const double sp = std::sin(rpy[1]);
  const double cy = std::cos(rpy[2]);
  const double sy = std::sin(rpy[2]);
  const Vector3 x{cy * cp, sy * cp, -sp};
  const Vector3 y{cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr};
  const Vector3 z{cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr};
  const auto& [px, py, pz] = position;
  return {x[0], x[1], x[2], 0, y[0], y[1], y[2], 0, z[0], z[1], z[2], 0, px, py, pz, 1};
}

setting::CollisionBehavior NoCollisionBehavior() noexcept {
  setting::CollisionBehavior behavior;
  for (JointVector* torque : {&behavior.lower_torque_acc, &behavior.upper_torque_acc,
                              &behavior.lower_torque_nominal, &behavior.upper_torque_nominal}) {
    torque->fill(kUnreachable);
  }
  for (Vector6* force : {&behavior.lower_force_acc, &behavior.upper_force_acc,
                         &behavior.lower_force_nominal, &behavior.upper_force_nominal}) {
    force->fill(kUnreachable);
  }
  return behavior;
}

bool PoseStep::operator==(const PoseStep& other) const {
  return position == other.position && rpy == other.rpy && by == other.by && turn == other.turn &&
         at == other.at;
}

bool PlanSection::operator==(const PlanSection& other) const {
  return goal == other.goal && seed == other.seed && budget == other.budget &&
         clearance == other.clearance && stretch == other.stretch;
}

bool MotionSection::operator==(const MotionSection& other) const {
  return interface == other.interface && controller == other.controller &&
         std::ranges::equal(waypoints, other.waypoints, &SamePoint) && poses == other.poses &&
         plan == other.plan && timing.duration == other.timing.duration &&
         timing.velocity_scale == other.timing.velocity_scale &&
         timing.acceleration_scale == other.timing.acceleration_scale &&
         timing.jerk_scale == other.timing.jerk_scale && touches == other.touches;
}

void Scenario::Validate() const {
  Scenario copy = *this;  // a map is bound to variables that it may change
  Map map;
  Describe(map, copy);
  map.Check("");
  ValidatePlant(*this);
  ValidateLoop(*this);
  application ? ValidateApplication(*this) : ValidateMotion(*this);
  RefuseIf(operator_section && !application,
           "operator: a motion follows its own path; leave the section out, or say "
           "application: {type: teleoperation}");
  if (operator_section) operator_section->Validate();
  (void)ObjectsOf(objects, seed);  // whether they can be drawn depends on the seed, too
  ValidateBase(*this);
  ValidatePose(*this);
  ValidateHand(*this);
  render.Validate();
}

}  // namespace twin::scenario

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

/// The synchronous loop sleeps on its own clock and the bare one is the robot's: they have no time
/// by which a state could be out of order, and the bare loop has no clock at all.
void ValidateLoop(const Scenario& scenario) {
  const ControllerSection& controller = scenario.controller;
  if (scenario.loop == loop::LoopKind::kAsynchronous) return;
  if (scenario.tick.period_tolerance != Duration::zero()) {
    throw InputError(
        "tick.period_tolerance: only the asynchronous loop has one; leave it out, or say loop: "
        "asynchronous");
  }
  if (scenario.loop != loop::LoopKind::kBare) return;
  if (controller.rate_hz == 1000 && controller.clock_drift_ppm == 0 &&
      controller.phase == Duration::zero() && controller.wake_delay == Delay()) {
    return;
  }
  throw InputError(
      "controller: the bare loop is paced by the robot, at 1000 Hz; rate, clock_drift, phase and "
      "wake_delay have no meaning in it: leave them out, or say loop: asynchronous");
}

void ValidatePlant(const PlantSection& plant) {
  if (plant.kind != robot::PlantKind::kIdeal) return;
  if (plant.mass_scale == 1 && plant.base_tilt == plant::BaseTilt()) return;
  throw InputError(
      "plant: the ideal plant does what INT wants, whatever it weighs and however it stands; leave "
      "mass_scale and base_tilt out, or say kind: mujoco");
}

/// Its drives follow each other.
void ValidateDrives(const std::vector<DriveEvent>& drive) {
  Duration end{};
  for (std::size_t i = 0; i < drive.size(); ++i) {
    if (drive[i].at < end) {
      throw InputError(
          fmt::format("base.drive[{}].at: {} s is before the end of the drive before it, {} s",
                      i + 1, ToSeconds(drive[i].at), ToSeconds(end)));
    }
    end = drive[i].at + drive[i].span;
  }
}

/// A mobile base rolls in the engine, and only a run's own motion may stand on one.
void ValidateBase(const Scenario& scenario) {
  if (!scenario.base) return;
  ValidateDrives(scenario.base->drive);
  const auto refuse = [](std::string_view why) {
    throw InputError(fmt::format("base: {}, or leave base out", why));
  };
  if (scenario.is_remote()) {
    refuse("a robot at the other end of a wire has none; say backend: mujoco");
  }
  if (scenario.plant.kind == robot::PlantKind::kIdeal) {
    refuse("the ideal plant has no wheels; say plant: {kind: mujoco}");
  }
  if (!(scenario.plant.base_tilt == plant::BaseTilt())) {
    refuse("it stands as its tyres let it; leave plant.base_tilt out");
  }
  if (scenario.motion.plan) {
    refuse("a motion is planned for an arm that stands on the world; give a trajectory or poses");
  }
  if (scenario.application && !scenario.base->drive.empty()) {
    throw InputError("base.drive: beside an application, which drives the base itself");
  }
}

void ValidatePerturbations(const Scenario& scenario) {
  if (scenario.perturbations.empty() || scenario.plant.kind != robot::PlantKind::kIdeal) return;
  throw InputError(
      "perturbations: the ideal plant feels no forces; say plant: {kind: mujoco}, or leave them "
      "out");
}

/// Whether objects can be drawn depends on the seed too.
void ValidateObjects(const Scenario& scenario) {
  (void)ObjectsOf(scenario.objects, scenario.seed);
}

void ValidatePanel(const std::vector<robot::PanelEvent>& panel) {
  const auto earlier = [](const auto& a, const auto& b) { return a.at < b.at; };
  if (std::ranges::is_sorted(panel, earlier)) return;
  throw InputError("panel: its events must be in order of time");
}

void ValidateHand(const Scenario& scenario) {
  const std::vector<HandEvent>& hand = scenario.hand;
  if (hand.empty()) return;
  if (scenario.robot.hand == plant::HandKind::kNone) {
    throw InputError(
        "hand: robot.hand is none, so there is nothing to command; say robot: {hand: franka_hand}, "
        "or leave the commands out");
  }
  const auto earlier = [](const auto& a, const auto& b) { return a.at < b.at; };
  if (!std::ranges::is_sorted(hand, earlier)) {
    throw InputError("hand: its commands must be in order of time");
  }
}

/// What is planned has no points but its ends, and only shares of the limits for its pace.
void ValidatePlan(const Scenario& scenario) {
  const MotionSection& motion = scenario.motion;
  if (!motion.plan) return;
  if (!motion.waypoints.empty() || !motion.poses.empty()) {
    throw InputError(
        "motion.plan: waypoints or poses beside it; a motion has one of trajectory, poses, plan");
  }
  if (!scenario.robot.q_start) {
    throw InputError(
        "motion.plan: it begins at robot.q_start, which is not given; give it, as robot: {q_start: "
        "{unit: rad, values: [...]}}");
  }
  if (!scenario.hand.empty()) {
    throw InputError(
        "motion.plan: it takes the hand to stay as it is; leave the commands to the hand out");
  }
  if (motion.timing.duration) {
    throw InputError(
        "motion.plan: a duration cannot be asked for; give shares of the limits, or stretch");
  }
}

void ValidateMotion(const MotionSection& motion) {
  if (!motion.poses.empty() && motion.waypoints.size() != 1) {
    throw InputError(
        fmt::format("motion.poses: {} points through joint space beside them; give one, where the "
                    "arm begins",
                    motion.waypoints.size()));
  }
  if (motion.poses.empty() && !motion.plan && motion.waypoints.size() < 2) {
    throw InputError(fmt::format("motion.trajectory: {} waypoints; a trajectory needs at least two",
                                 motion.waypoints.size()));
  }
}

/// It begins where the robot stands, and makes its motions and commands to the hand itself.
void ValidateApplication(const Scenario& scenario) {
  const MotionSection& motion = scenario.motion;
  if (!motion.waypoints.empty() || !motion.poses.empty() || motion.plan) {
    throw InputError("motion: beside an application, which makes its motions itself");
  }
  if (!scenario.robot.q_start) {
    throw InputError(
        "application: it begins at robot.q_start, which is not given; give it, as robot: {q_start: "
        "{unit: rad, values: [...]}}");
  }
  if (!scenario.hand.empty()) {
    throw InputError("hand: beside an application, which commands the hand itself");
  }
}

void ValidateOperator(const Scenario& scenario) {
  if (!scenario.application) {
    throw InputError(
        "operator: a motion has its path, and nobody leads it; leave it out, or say application: "
        "{type: teleoperation}");
  }
  scenario.operator_section->Validate();
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
  return {cy * cp,
          sy * cp,
          -sp,
          0,
          cy * sp * sr - sy * cr,
          sy * sp * sr + cy * cr,
          cp * sr,
          0,
          cy * sp * cr + sy * sr,
          sy * sp * cr - cy * sr,
          cp * cr,
          0,
          position[0],
          position[1],
          position[2],
          1};
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
         timing.jerk_scale == other.timing.jerk_scale;
}

void Scenario::Validate() const {
  Scenario copy = *this;  // a map is bound to variables that it may change
  Map map;
  Describe(map, copy);
  map.Check("");
  ValidatePlant(plant);
  ValidateLoop(*this);
  if (application) {
    ValidateApplication(*this);
  } else {
    ValidateMotion(motion);
    ValidatePlan(*this);
  }
  if (operator_section) ValidateOperator(*this);
  ValidateObjects(*this);
  ValidatePerturbations(*this);
  ValidateBase(*this);
  ValidatePanel(panel);
  ValidateHand(*this);
  render.Validate();
}

}  // namespace twin::scenario

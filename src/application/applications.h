#pragma once

#include <memory>

#include "twin/application/application.h"
#include "twin/control/parameters.h"

// The paper's four applications, made from their parameters.
// @throws InputError as ParameterReader's functions.
namespace twin::application {

/// Plans and executes motions from the arm's position to random goals, free of collision with the
/// scene, followed by joint torques.
///
/// Parameters:
///   goals       their number, in [1, 100], default 1
///   clearance   from all parts, m, in [1 mm, 100 mm], default 15 mm
///   budget      collision checks per plan, in [1, 10^9], default 100 000
///   controller  of joint_trajectory_effort
///
/// Steps: plan and execute, for each goal. Demands: no contact, in an independent check of every
/// millisecond of the plan and in a simulated run; the measured arm within the controller's path
/// tolerance.
[[nodiscard]] std::unique_ptr<Application> MakePlanAndExecute(control::ParameterReader& parameters);

/// The arm as a spring, by the controller `compliance` on the torque interface: pushed at a
/// standstill and on a trajectory, stiff and compliant.
///
/// Each case is a motion; a motion back to robot.q_start separates two cases: A standstill, stiff,
/// pushed; B likewise, compliant; C0 trajectory, stiff, without a push; C likewise, pushed; D0
/// trajectory, compliant, without a push; D likewise, pushed; N standstill, stiff, with a null
/// space that moves the elbow. C0 and C, D0 and D differ only in the push, which separates its
/// effect from other motion.
///
/// The pushes are the scenario's perturbations with `motion: N`, the same for local and remote
/// robots. Parameters: compliance::Config. Demands: compliance::EvaluateCases(), from the log's
/// states alone and hence on any drive.
[[nodiscard]] std::unique_ptr<Application> MakeCompliance(control::ParameterReader& parameters);

/// Moves an object from one surface to another and rotates it, through the joint position interface
/// by damped least squares. Parameters: PickParameters.
///
///   plan -> approach -> grasp -> lift -> transfer -> place -> release -> retreat
///
/// After a grasp that holds nothing, or an object of another width, the hand opens and backs off,
/// and the task repeats the approach. If a robot error ends a path and the hand's state is right,
/// the path is planned again from the arm's position, once. During the transport, the robot's load
/// is the object's mass.
[[nodiscard]] std::unique_ptr<Application> MakePickAndPlace(control::ParameterReader& parameters);

/// An operator moves arm and mobile base with a device, fetches an object beyond the arm's reach
/// and sets it down at a target: one motion of the compliance controller with a live reference,
/// until the operator ends it. The hand closes and opens at the operator's button presses.
///
/// Parameters:
///   object      object of the scenario that the scripted operator fetches
///   from        {heading}: of the base at the object, rad
///   to          {position, heading}: of the target surface, world, m; of the base, rad
///   reach       from the arm's base to object and target, along the heading, m; default 0.55 m
///   longest     longest duration; default 240 s for the scripted operator, else 1800 s
///   grasp       {force, speed} of the hand
///   controller  parameters of compliance; default: the paper's gains of teleoperation
///   person      {reaction, hand_noise, tremor, eye_noise, far_noise}: ScriptedOperatorConfig
///
/// Demands: no robot error; the object released within 3 cm of its target; the arm within 1 cm of
/// its reference while the base drives; jerks of all commands within the operator's limits, also at
/// mode switches; energy out of the operator's port at most its reserve.
///
/// `operator.device: person` selects this application's scripted operator; the catalogue has the
/// other devices.
[[nodiscard]] std::unique_ptr<Application> MakeTeleoperation(control::ParameterReader& parameters);

}  // namespace twin::application

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
///   clearance   kept from everything, m, in [1 mm, 100 mm], default 15 mm
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
/// Cases, each a motion, with a motion back to robot.q_start between two of them: A standstill,
/// stiff, pushed; B the same, compliant; C0 trajectory, stiff, untouched; C the same, pushed; D0
/// trajectory, compliant, untouched; D the same, pushed; N standstill, stiff, with a null space
/// that pulls the elbow elsewhere. C0 and C, D0 and D differ by the push alone, which separates its
/// effect from all other motion.
///
/// The pushes are the scenario's perturbations, with `motion: N`, so local and remote robots are
/// pushed in the same way. Parameters: compliance::Config. Demands: compliance::EvaluateCases, from
/// the states in the log alone, so on any drive.
[[nodiscard]] std::unique_ptr<Application> MakeCompliance(control::ParameterReader& parameters);

/// Takes an object from one surface and puts it, turned, on another, through the joint position
/// interface by damped least squares. Parameters: PickParameters.
///
///   plan -> approach -> grasp -> lift -> transfer -> place -> release -> retreat
///
/// A grasp that holds nothing, or something of another width, is repeated: open, away, approach. A
/// path that the robot ended by an error is planned anew from where the arm stopped, once, while
/// the hand holds what it should. During the transport the robot's load is the object's mass.
[[nodiscard]] std::unique_ptr<Application> MakePickAndPlace(control::ParameterReader& parameters);

/// An operator leads arm and mobile base by a device, fetches an object beyond the arm's reach and
/// sets it down elsewhere: one motion of the compliance controller with a live reference, from the
/// start until the operator ends it. The hand closes and opens at the operator's presses.
///
/// Parameters:
///   object      that the scripted operator fetches, one of the scenario's
///   from        {heading}: of the base before the object, rad
///   to          {position, heading}: of the target surface, world, m; of the base
///   reach       from the arm's base to object and target, along the heading, m; default 0.55 m
///   longest     duration; default 240 s for the scripted operator, else 1800 s
///   grasp       {force, speed} of the hand
///   controller  of compliance; default: the paper's gains of teleoperation
///   person      {reaction, hand_noise, tremor, eye_noise, far_noise}: ScriptedOperatorConfig
///
/// Demands: no error of the robot; the object released within 3 cm of its target; the arm within 1
/// cm of its reference while the base drives; jerks of all commands, at mode switches too, within
/// the operator's limits; no energy from the operator's port beyond its reserve.
///
/// `operator.device: person` is the scripted operator of this application; the catalogue has the
/// other devices.
[[nodiscard]] std::unique_ptr<Application> MakeTeleoperation(control::ParameterReader& parameters);

}  // namespace twin::application

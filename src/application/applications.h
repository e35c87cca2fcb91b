#pragma once

#include <memory>

#include "twin/application/application.h"
#include "twin/control/parameters.h"

// The paper's four applications and those of several robots, made from their parameters.
// models/applications/README.md documents parameters, steps and demands. @throws InputError as
// ParameterReader's functions.
namespace twin::application {

/// Motions to random goals on planned paths, free of collision with the scene, by joint torques.
[[nodiscard]] std::unique_ptr<Application> MakePlanAndExecute(control::ParameterReader& parameters);

/// The arm as a spring, by the controller `compliance` on the torque interface: pushed at a
/// standstill and on a trajectory, stiff and compliant (compliance.h).
[[nodiscard]] std::unique_ptr<Application> MakeCompliance(control::ParameterReader& parameters);

/// Moves an object from one surface to another and rotates it, through the joint position interface
/// by damped least squares (pick.h).
[[nodiscard]] std::unique_ptr<Application> MakePickAndPlace(control::ParameterReader& parameters);

/// Hands an object over from one arm to another: the giver picks it up and holds it out, the
/// receiver takes it and puts it down (pick.h). Each is the application of one robot of a cell.
[[nodiscard]] std::unique_ptr<Application> MakeHandOver(control::ParameterReader& parameters);

/// An operator moves arm and mobile base with a device: one motion of the compliance controller
/// with a live reference, until the operator ends it. `operator.device: person` selects the
/// scripted operator (scripted_operator.h); the catalogue has the other devices.
[[nodiscard]] std::unique_ptr<Application> MakeTeleoperation(control::ParameterReader& parameters);

}  // namespace twin::application

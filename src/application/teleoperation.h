#pragma once

#include <memory>

#include "twin/application/application.h"
#include "twin/control/parameters.h"

namespace twin::application {

/// The paper's fourth application: somebody leads arm and mobile base by a device, fetches an
/// object that lies beyond the arm's reach and sets it down elsewhere. One motion of the compliance
/// controller with a live reference, from the start until the operator ends it; the hand closes and
/// opens at the operator's presses.
///
/// Parameters:
///   object      that a scripted person fetches, one of the scenario's
///   from        {heading}: of the base before it, rad
///   to          {position, heading}: of the surface on which it is set down, world, m; of the base
///   reach       from the arm's base to object and place, along the heading, m; 0.55 m unless said
///   longest     that it may take; unless said 240 s for the scripted person, else 1800 s
///   grasp       {force, speed} of the hand
///   controller  of compliance; the paper's gains of teleoperation unless said
///   person      {reaction, hand_noise, tremor, eye_noise, far_noise}: see ScriptedOperatorConfig
///
/// Demanded: no error of the robot; the object stands within 3 cm of its target, let go; the arm
/// within 1 cm of its reference while the base drives; jerks of all commands, at switches of the
/// mode too, within the operator's settings; no energy from the operator's port beyond its reserve.
///
/// `operator.device: person` is a scripted person, who is of this application; every other device
/// is the catalogue's. @throws InputError as ParameterReader's functions.
[[nodiscard]] std::unique_ptr<Application> MakeTeleoperation(control::ParameterReader& parameters);

}  // namespace twin::application

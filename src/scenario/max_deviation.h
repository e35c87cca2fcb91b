#pragma once

#include <string>

#include "scenario/yaml_node.h"
#include "twin/scenario/max_deviation.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// {joints: 20 mrad} of joints, {position: 20 mm, angle: 20 mrad} of poses, all three beside an
/// application, each a limit or off; or off. @param scenario  with its motion or application.
/// @throws InputError naming file, line and key.
[[nodiscard]] MaxDeviation ReadMaxDeviation(const YamlNode& node, const Scenario& scenario);

/// The line of a scenario that says so; empty when it says nothing.
[[nodiscard]] std::string MaxDeviationText(const MaxDeviation& max);

/// What the scenario says of a motion on this interface, which the robot follows by `impedance`.
/// What it does not say is 20 mrad, or 20 mm and 20 mrad of poses, times as often as the robot is
/// softer (int.K_theta, int.K_x) than as delivered: what friction, inertia and loads take from its
/// path is a force over its stiffness. Not judged unless it is said: torques, which are as stiff as
/// their controller, and a scenario with perturbations, which are there to move the arm off its
/// path.
[[nodiscard]] DeviationLimit LimitOf(const Scenario& scenario, control::CommandInterface interface,
                                     ControllerMode impedance);

}  // namespace twin::scenario

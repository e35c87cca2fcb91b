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

}  // namespace twin::scenario

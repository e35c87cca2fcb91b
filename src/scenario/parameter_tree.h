#pragma once

#include <string>

#include "scenario/yaml_node.h"
#include "twin/control/parameters.h"

// Parameters of a controller, an application or a device in a scenario: keys and values of its own,
// which only it understands.
namespace twin::scenario {

/// A map of plain values, lists of plain values, and such maps, made flat: the keys dotted.
/// @throws InputError naming file, line and key for anything else, and for keys that are no words.
[[nodiscard]] control::Parameters ReadParameters(const YamlNode& node);

/// As a YAML map in one line. ReadParameters() of it gives the same.
[[nodiscard]] std::string ParametersText(const control::Parameters& parameters);

}  // namespace twin::scenario

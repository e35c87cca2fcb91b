#pragma once

#include "twin/scenario/scenario.h"
#include "twin/teleop/teleoperator_config.h"

// The configuration of a teleoperator from the section `operator`.
namespace twin::scenario {

/// From the key `settings`. @throws InputError naming file, line and key.
[[nodiscard]] teleop::TeleoperatorConfig MakeTeleoperator(const OperatorSection& section);

/// The link between operator and robot. @throws InputError when a parameter is outside its range.
[[nodiscard]] teleop::WireConfig MakeWire(const OperatorSection& section);

}  // namespace twin::scenario

#pragma once

#include "twin/scenario/scenario.h"
#include "twin/teleop/teleoperator_config.h"

// The section `operator`, as a teleoperator takes it.
namespace twin::scenario {

/// How the operator leads: `settings`. @throws InputError naming file, line and key.
[[nodiscard]] teleop::TeleoperatorConfig MakeTeleoperator(const OperatorSection& section);

/// The way between operator and robot. @throws InputError when a parameter is outside its range.
[[nodiscard]] teleop::WireConfig MakeWire(const OperatorSection& section);

}  // namespace twin::scenario

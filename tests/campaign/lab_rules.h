#pragma once

#include "conformance/reference_rules.h"
#include "twin/core/robot_state.h"
#include "twin/model/lab_limits.h"

namespace twin::campaign {

/// Whether a state's reference is beyond a region or a cap on speed of the lab's.
[[nodiscard]] test::Finding FindBeyondLab(const RobotState& state, const model::LabLimits& limits,
                                          bool with_hand);

}  // namespace twin::campaign

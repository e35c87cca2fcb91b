#pragma once

#include <vector>

#include "twin/experiment/findings.h"
#include "twin/reference/viable_axis.h"

namespace twin::experiment {

/// The highest velocity from which a joint's limits can be kept for ever.
/// @param q, ddq  rad, rad/s^2. @returns rad/s; 0 where there is none.
[[nodiscard]] double HighestSpeed(const reference::ViableAxis& axis, double q, double ddq);

/// The least distance to the upper end of the range at which full speed, without acceleration, is
/// viable, rad.
[[nodiscard]] double StoppingDistance(const reference::ViableAxis& axis);

/// How long a joint takes from rest until close to its goal when it always asks for the largest
/// jerk, and the filter, for which the goal is the end of the range, has it stop there.
/// Nothing is lost. Without losses to reckon with (lost = 0) that is the fastest way there is.
/// @param bounds  of the joint. @param distance  rad, below its range. @param close  rad.
/// @returns s.
[[nodiscard]] double RestToRestTime(const reference::AxisBounds& bounds, int lost, double distance,
                                    double close = 1e-3);

/// Borders of the set, and what it costs to reckon with losses: figures and what they must be.
/// @param bounds  of the joints.
void AddViableSet(const std::vector<reference::AxisBounds>& bounds, Findings& findings);

}  // namespace twin::experiment

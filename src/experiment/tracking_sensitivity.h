#pragma once

#include "twin/experiment/experiment.h"
#include "twin/reference/trajectory.h"

namespace twin::experiment {

/// Which noise of the measured velocity, and which spread of the states' arrival at the synchronous
/// loop, bring the ratio of the powers in 20 to 150 Hz (synchronous to proposed, joint 1) to the
/// paper's 10: by runs at levels of each, a figure of them, and the levels. Progress from `from` to
/// 1.
void AddLevels(const Setting& setting, const reference::Trajectory& plan, double from,
               Findings& findings);

}  // namespace twin::experiment

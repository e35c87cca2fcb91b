#pragma once

#include "report/run_data.h"
#include "twin/core/limits.h"
#include "twin/report/plot.h"

namespace twin::report {

// The figures of a run; their files in src/report/templates/run describe them.
[[nodiscard]] Figure JointsFigure(const RunData& run, const JointLimits& limits);
[[nodiscard]] Figure VelocitiesFigure(const RunData& run, const JointLimits& limits);
[[nodiscard]] Figure TrackingFigure(const RunData& run);
[[nodiscard]] Figure JerkFigure(const RunData& run, const JointLimits& limits);
[[nodiscard]] Figure TorquesFigure(const RunData& run, const JointLimits& limits);
[[nodiscard]] Figure ServedFigure(const RunData& run);
/// @pre run.filter.commands > 0.
[[nodiscard]] Figure ViabilityFigure(const RunData& run);

}  // namespace twin::report

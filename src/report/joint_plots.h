#pragma once

#include <string>

#include "report/run_data.h"
#include "twin/core/limits.h"

namespace twin::report {

// The scripts of the plots with one panel per joint; see plots.h.

[[nodiscard]] std::string PositionScript(const RunData& run, const JointLimits& limits);
[[nodiscard]] std::string VelocityScript(const RunData& run, const JointLimits& limits);
[[nodiscard]] std::string TrackingScript(const RunData& run);
[[nodiscard]] std::string JerkScript(const RunData& run, const JointLimits& limits);
[[nodiscard]] std::string TorqueScript(const RunData& run, const JointLimits& limits);

/// Script of served.svg.
[[nodiscard]] std::string ServedScript(const RunData& run);

/// Script of viability.svg. @pre run.filter.commands > 0.
[[nodiscard]] std::string ViabilityScript(const RunData& run);

}  // namespace twin::report

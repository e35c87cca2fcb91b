#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/paragraphs.h"
#include "report/run_end.h"
#include "twin/core/robot_errors.h"
#include "twin/report/explanation.h"

namespace twin::report {

// What kept the last commands away from the plan. Each text consists of whole sentences; empty:
// nothing to tell. @pre end.aborted().

/// Noise that the scenario adds to the targets, where it is large enough to matter: alone for this
/// error, or for the limits of jerk.
[[nodiscard]] std::string TellNoise(const RunEnd& end, const Violation& v,
                                    const ScenarioFacts& facts);

/// Commands that the viability filter changed, if they are most.
[[nodiscard]] std::string TellKeptBack(const RunEnd& end);

/// What hindered a run that ended early without an error of the robot: noise, and commands kept
/// back in all of it.
[[nodiscard]] std::vector<Paragraph> TellHindrances(const RunEnd& end,
                                                    const std::optional<ScenarioFacts>& facts);

/// Distance of the measured joints from the targets, if it is large.
[[nodiscard]] std::string TellDeviation(const RunEnd& end);

/// What brings such commands back to the plan, for this scenario.
[[nodiscard]] std::string RemedyOfDeviation(const RunEnd& end,
                                            const std::optional<ScenarioFacts>& facts);

}  // namespace twin::report

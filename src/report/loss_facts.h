#pragma once

#include <string>

#include "report/run_end.h"
#include "twin/report/explanation.h"

namespace twin::report {

// Relation between the commands of the last cycles and the error. Each text consists of whole
// sentences. @pre end.aborted().

/// Draws again, from the seed, what the emulated link did with the messages of the last cycles.
void AddLinkFates(RunEnd& end, const LinkFacts& link);

/// Why a held cycle had no command, in a few words: "lost", "0.21 ms late"; empty: not known.
[[nodiscard]] std::string WhyHeld(const EndCycle& cycle);

/// Whether a shown cycle was held.
[[nodiscard]] bool AnyHeld(const RunEnd& end);

/// States whether earlier command losses may have led to the error. Empty if the error itself says
/// so, or the log has no fates of commands.
[[nodiscard]] std::string JudgeLosses(const RunEnd& end);

/// Counts the served and held cycles among those shown, and the reasons of the held ones: no state,
/// no command, or a late command; or says that this log has no such data.
[[nodiscard]] std::string CountFates(const RunEnd& end);

/// The longest time, among the shown cycles, for which commands repeated one torque, if that is
/// notable: a controller that slept while the arm moved. Held cycles do not count. Else empty.
[[nodiscard]] std::string TellRepeatedTorque(const RunEnd& end);

/// Describes notable actions of the workstation in these cycles; empty without any.
[[nodiscard]] std::string CountTicks(const RunEnd& end);

}  // namespace twin::report

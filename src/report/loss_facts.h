#pragma once

#include <string>

#include "report/run_end.h"

namespace twin::report {

// Relation between the commands of the last cycles and the error. Each text consists of whole
// sentences. @pre end.aborted().

/// States whether earlier command losses may have led to the error. Empty if the error itself says
/// so, or the log has no fates of commands.
[[nodiscard]] std::string JudgeLosses(const RunEnd& end);

/// Counts the served and held cycles among those shown, and the reasons of the held ones: no state,
/// no command, or a late command; or says that this log has no such data.
[[nodiscard]] std::string CountFates(const RunEnd& end);

/// Describes notable actions of the workstation in these cycles; empty without any.
[[nodiscard]] std::string CountTicks(const RunEnd& end);

}  // namespace twin::report

#pragma once

#include <string>

#include "report/run_end.h"

namespace twin::report {

// What the commands of the last cycles have to do with the error. Each text is whole sentences.
// @pre end.aborted().

/// Whether commands that were lost before can be what led to the error; empty when the error says
/// so itself, or when it is not known what became of commands.
[[nodiscard]] std::string JudgeLosses(const RunEnd& end);

/// How many of the shown cycles were served and held, and where the commands of the held ones went:
/// no state, no command, or a command that came too late; or that this log cannot tell.
[[nodiscard]] std::string CountFates(const RunEnd& end);

/// What the workstation did in these cycles, as far as it is worth a word; empty when it is not.
[[nodiscard]] std::string CountTicks(const RunEnd& end);

}  // namespace twin::report

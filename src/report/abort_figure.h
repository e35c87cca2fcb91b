#pragma once

#include <string>

#include "report/run_end.h"

namespace twin::report {

/// Script of the figure about the end of a run: EndPanels one below the other over the last cycles,
/// and what became of each cycle's command. Cycles that held are shaded in all panels.
/// @pre end.aborted().
[[nodiscard]] std::string EndScript(const RunEnd& end);

}  // namespace twin::report

#pragma once

#include <string>

#include "report/run_end.h"

namespace twin::report {

/// gnuplot script for the end of a run: the EndPanels, one below the other, over the last cycles,
/// and the fate of each cycle's command. Held cycles are shaded in all panels.
/// @pre end.aborted().
[[nodiscard]] std::string EndScript(const RunEnd& end);

}  // namespace twin::report

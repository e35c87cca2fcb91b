#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "report/run_end.h"
#include "twin/report/plot.h"

namespace twin::report {

/// A curve over the last cycles: one value per cycle of RunEnd::cycles; values that are not finite
/// are not drawn.
struct EndCurve {
  std::string name;
  std::string_view colour;
  std::vector<double> values;
  bool points = false;  ///< single values instead of a line
};

/// A panel of the figure about the end of a run.
struct EndPanel {
  std::string title;
  std::string unit;
  std::vector<EndCurve> curves{};
  std::vector<double> limits{};      ///< drawn if within the range
  bool limits_in_view = false;       ///< extend the range to the limits
  std::optional<double> offender{};  ///< the value that ended the run, at the last cycle
};

/// Panels that show the cause of a run's end: first the quantity that violated a limit, with this
/// limit, then related quantities of the same joint or axis. @pre end.aborted().
[[nodiscard]] std::vector<EndPanel> EndPanels(const RunEnd& end);

/// Figure of a run's end, drawn by templates/run/end.gp: the panels, one below the other, over the
/// last cycles, and the fate of each cycle's command. Held cycles are shaded in all panels.
/// @pre end.aborted().
[[nodiscard]] Figure EndFigure(const RunEnd& end, const std::vector<EndPanel>& panels);

}  // namespace twin::report

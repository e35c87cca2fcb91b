#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "report/run_end.h"

namespace twin::report {

/// A curve over the last cycles: one value per cycle of RunEnd::cycles; what is not finite is not
/// drawn.
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
  std::vector<double> limits{};      ///< drawn where they are in view
  bool limits_in_view = false;       ///< the range is made to hold them
  std::optional<double> offender{};  ///< the value that ended the run, at the last cycle
};

/// What shows how the run came to its end: first what broke the limit, against it, then what is
/// around it of the same joint or axis. @pre end.aborted().
[[nodiscard]] std::vector<EndPanel> EndPanels(const RunEnd& end);

}  // namespace twin::report

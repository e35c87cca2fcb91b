#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/paragraphs.h"
#include "report/run_end.h"

namespace twin::report {

/// The self-contained HTML page about an aborted run. Draws with gnuplot.
/// @param headline  the error in one line. @pre end.aborted(). @throws EnvironmentError as SvgOf().
[[nodiscard]] std::string AbortPage(const RunEnd& end, std::string_view headline,
                                    const std::vector<Paragraph>& paragraphs);

/// "9.01 of 12.5 rad/s^2, joint 4, at 3.214 s".
[[nodiscard]] std::string PlaceOf(const Approach& approach);

}  // namespace twin::report

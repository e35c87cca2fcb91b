#pragma once

#include <string>
#include <vector>

#include "report/paragraphs.h"
#include "report/run_end.h"

namespace twin::report {

/// An abort and the text about it.
struct ToldAbort {
  const RunEnd* end = nullptr;  ///< aborted
  std::string headline;         ///< the error in one line
  std::vector<Paragraph> paragraphs;
};

/// The self-contained HTML page about the aborts of a run. Draws with gnuplot.
/// @param aborts  not empty. @param rest  a sentence about aborts that the page leaves out; empty:
/// none. @throws EnvironmentError as SvgOf().
[[nodiscard]] std::string AbortPage(const std::vector<ToldAbort>& aborts, const std::string& title,
                                    const std::string& rest);

/// "9.01 of 12.5 rad/s^2, joint 4, at 3.214 s".
[[nodiscard]] std::string PlaceOf(const Approach& approach);

}  // namespace twin::report

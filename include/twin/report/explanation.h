#pragma once

#include <filesystem>
#include <string>

namespace twin::report {

/// Explanation of a run's end.
struct Explanation {
  bool aborted = false;  ///< an error ended a motion
  /// Text for a terminal, in lines of at most 100 columns: the error and its place; value, limit
  /// and derivation of the value; fate of the last commands, and whether losses may have caused the
  /// error; usual cause and cure. A log from the workstation's end of a wire has neither the fates
  /// nor the value; the text then says so. For a run without an error: how close the run came to
  /// each limit.
  std::string text;
  /// The same as a self-contained HTML page, with plots and numbers of the last 50 cycles. Empty
  /// unless aborted.
  std::string page;
};

/// Faults that the run's scenario injected on purpose and a log does not show.
struct Injected {
  double target_noise = 0;   ///< largest, on every target, in the unit of what was commanded
  bool is_smoothed = false;  ///< a reference generator is between the noise and the robot
};

/// Explains the first error of a log, which may be that of a killed run. The same log gives the
/// same bytes, with the same version of gnuplot.
///
/// Threads: one thread. Not real-time: for an aborted run it runs gnuplot from PATH and waits.
/// @param log  written by record::Recorder. @param injected  named where it can be the cause.
/// @throws InputError if the log is damaged, has no cycle, or is that of a run killed before any
/// error; EnvironmentError if it cannot be read, or gnuplot is missing or fails.
[[nodiscard]] Explanation Explain(const std::filesystem::path& log, const Injected& injected = {});

}  // namespace twin::report

#pragma once

#include <filesystem>
#include <string>

namespace twin::report {

/// What a log tells about how its run ended.
struct Explanation {
  bool aborted = false;  ///< an error ended a motion
  /// For a terminal: what happened, where, value and limit and how the value came about, what
  /// became of the last commands and whether lost ones can be the reason (a log from the
  /// workstation's end of a wire knows neither this nor the value, and says so), the usual cause,
  /// the cure; of a run without an error, how close it came to each limit. Lines of at most 100
  /// columns.
  std::string text;
  /// The same as one HTML page with the last 50 cycles plotted and in numbers; it needs no other
  /// file and no network. Empty unless aborted.
  std::string page;
};

/// Explains the first error of a log; of a killed run's log as far as it goes. The same log gives
/// the same bytes, with the same version of gnuplot.
///
/// Threads: one thread. Real-time: no; of an aborted run it runs gnuplot from PATH and waits for
/// it.
/// @param log  as record::Recorder wrote it.
/// @throws InputError when the log is damaged, holds no cycle, or ends with its run killed and no
/// error before; EnvironmentError when it cannot be read, or gnuplot is missing or fails.
[[nodiscard]] Explanation Explain(const std::filesystem::path& log);

}  // namespace twin::report

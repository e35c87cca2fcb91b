#pragma once

#include <cstdint>
#include <filesystem>

namespace twin::record {

/// What ExportCsv() wrote, in rows without the heading.
struct CsvExport {
  std::uint64_t cycles = 0;
  std::uint64_t ticks = 0;
  std::uint64_t events = 0;
  bool truncated = false;  ///< the log is of a killed run: its last part is missing
};

/// Writes a log as CSV into `folder`, which is made when missing: cycles.csv, ticks.csv,
/// events.csv, and config.csv with the quantities of the robot state that seldom change, a row
/// whenever one does. Of a robot on a mobile base also base.csv, a row a cycle. Files of these
/// names are replaced; each is `.partial` until it is whole.
///
/// Scenes and plans, which serve pictures, have no table.
///
/// One row per record, in the order of the log. Vectors have a column per element, `q[0]` to
/// `q[6]`; times are whole nanoseconds of the run (`at_ns`); numbers are the shortest text that
/// reads back to the same double; modes, fates and errors are names, several errors joined by '|'.
/// RFC 4180, but lines end in LF.
///
/// Threads: one thread. Real-time: no.
/// @throws InputError when the log is damaged or no file; EnvironmentError when it cannot be read
/// or a file not be written. Nothing is then left behind but files that were whole already.
CsvExport ExportCsv(const std::filesystem::path& log, const std::filesystem::path& folder);

}  // namespace twin::record

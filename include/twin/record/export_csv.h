#pragma once

#include <cstdint>
#include <filesystem>

namespace twin::record {

/// Rows that ExportCsv() wrote, without headings.
struct CsvExport {
  std::uint64_t cycles = 0;
  std::uint64_t ticks = 0;
  std::uint64_t events = 0;
  bool truncated = false;  ///< the run was killed and the log's last part is missing
};

/// Writes a log as CSV into `folder`, which is created if missing: cycles.csv, ticks.csv,
/// events.csv, and config.csv with a row per change of the robot state's rarely changing
/// quantities. With a mobile base also base.csv, one row per cycle. Existing files of these names
/// are replaced; each is `.partial` until complete.
///
/// Scenes and plans, which serve pictures, are not exported.
///
/// One row per record, in log order. Vectors have a column per element, `q[0]` to `q[6]`; times are
/// integer nanoseconds of the run (`at_ns`); numbers are the shortest text that reads back to the
/// same double; modes, fates and errors are names, several errors joined by '|'. RFC 4180, but
/// lines end in LF.
///
/// Threads: one thread. Real-time: no.
/// @throws InputError if the log is damaged or not a file; EnvironmentError if it cannot be read or
/// a file cannot be written. Only complete files then remain.
CsvExport ExportCsv(const std::filesystem::path& log, const std::filesystem::path& folder);

}  // namespace twin::record

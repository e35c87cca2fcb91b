#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace twin::record {

/// Rows that an export wrote, without headings.
struct LogExport {
  std::uint64_t cycles = 0;
  std::uint64_t ticks = 0;
  std::uint64_t events = 0;
  bool truncated = false;  ///< the run was killed and the log's last part is missing
};

/// Writes a log as CSV into `folder`, which is created if missing: a file per table of LogTables(),
/// such as cycles.csv. Basic tables are always there, others if they have rows. Existing files of
/// these names are replaced; each is `.partial` until complete.
///
/// One row per record, in log order. Vectors have a column per element, `q[0]` to `q[6]`; times are
/// integer nanoseconds of the run (`at_ns`); floats are the shortest text that reads back to the
/// same double, with a decimal point or an exponent in every row, so that readers that infer types
/// from the first rows are right; modes, fates and errors are names, several errors joined by '|'.
/// RFC 4180, but lines end in LF.
///
/// Threads: one thread. Real-time: no. Memory: as McapReader.
/// @param columns  names, of any table; a table is written if it has one of them, with its time and
/// those. Empty: all.
/// @throws InputError if the log is damaged or not a file, or a column is unknown; EnvironmentError
/// if it cannot be read or a file cannot be written. Only complete files then remain.
LogExport ExportCsv(const std::filesystem::path& log, const std::filesystem::path& folder,
                    std::span<const std::string> columns = {});

/// Writes the same tables as NumPy archives: cycles.npz has an array `q` of shape (n, 7). Of a
/// column of texts, `fate` has numbers (int32) and `fate.names` the texts that they number.
///
/// Memory: a table. @throws as ExportCsv; InputError for a table of more than 4 GiB.
LogExport ExportNpz(const std::filesystem::path& log, const std::filesystem::path& folder,
                    std::span<const std::string> columns = {});

}  // namespace twin::record

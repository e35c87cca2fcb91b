#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "twin/record/columns.h"
#include "twin/record/log_records.h"

namespace twin::record {

/// Reads tables of a log, several threads at once. Opening reads where the chunks are, not what
/// they hold; Read() takes the chunks of an interval and decodes the columns that are wanted.
///
/// Values are those of LogReader, an omitted vector is zero. Chunks pass their CRC before use; the
/// CRC of the whole file, which LogReader checks too, is not computed.
///
/// Threads: any. Real-time: no. Errors: InputError for bytes that are not a log, and for a table
/// that takes more than kMostBytes; EnvironmentError if the file cannot be read.
class ColumnReader {
 public:
  /// Largest accepted table, bytes: 80 minutes of all columns of the cycles.
  static constexpr std::uint64_t kMostBytes = std::uint64_t{8} << 30;

  explicit ColumnReader(const std::filesystem::path& path);
  /// Reads bytes in memory, which must outlive the reader. @param name  for error messages.
  ColumnReader(std::span<const std::byte> bytes, const std::string& name);
  ~ColumnReader();

  [[nodiscard]] const RunInfo& run() const;
  /// True if the run was killed before the log was finished.
  [[nodiscard]] bool truncated() const;
  /// Time of the first and the last message, ns; 0 and 0 of an empty log.
  [[nodiscard]] std::int64_t first_ns() const;
  [[nodiscard]] std::int64_t last_ns() const;
  /// Size of the chunks of an interval after decompression.
  [[nodiscard]] std::uint64_t BytesIn(const Interval& interval) const;

  /// @param table  of LogTables(). @param columns  numbers; the first is 0, the time.
  /// @param threads  1 to 64; no effect on the result.
  /// @returns the rows of the interval, in the log's order.
  [[nodiscard]] Table Read(const TableInfo& table, std::span<const std::size_t> columns,
                           const Interval& interval, int threads) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record

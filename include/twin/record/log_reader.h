#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <variant>

#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"
#include "twin/record/scene_record.h"

namespace twin::record {

/// One entry of a log.
using LogEntry = std::variant<CycleRecord, TickRecord, EventRecord, SceneRecord, PlanRecord>;

/// Reads a log of Recorder, complete or from a killed run. Returns records bit by bit as they were
/// put, in the same order. Data that a log omits returns as default, such as the violation of a
/// cycle without one. Unknown topics are skipped.
///
///     LogReader log(path);
///     LogEntry entry;
///     while (log.Next(entry)) { if (const auto* cycle = std::get_if<CycleRecord>(&entry)) ...
///     }
///
/// Threads: one thread. Real-time: no. Errors: InputError with file, offset and cause for any bytes
/// that are not a log; EnvironmentError if the file cannot be read.
class LogReader {
 public:
  explicit LogReader(const std::filesystem::path& path);
  /// Reads bytes in memory, which must outlive the reader. @param name  for error messages.
  LogReader(std::span<const std::byte> bytes, const std::string& name);
  ~LogReader();

  /// Reads the next entry. @returns false at the end, with `entry` unchanged.
  bool Next(LogEntry& entry);

  /// Description of the run; available at once.
  [[nodiscard]] const RunInfo& run() const;
  /// True if the run was killed before the log was finished; available at once.
  [[nodiscard]] bool truncated() const;
  /// Messages read so far, including skipped ones.
  [[nodiscard]] std::uint64_t message_count() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record

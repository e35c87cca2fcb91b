#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <variant>

#include "twin/record/log_records.h"
#include "twin/rt/cycle_record.h"
#include "twin/rt/scene_record.h"

namespace twin::record {

/// One thing out of a log.
using LogEntry =
    std::variant<rt::CycleRecord, rt::TickRecord, EventRecord, rt::SceneRecord, PlanRecord>;

/// Reads a log that Recorder wrote, whole or of a killed run, back into records, bit by bit as they
/// were put, in the order in which they were put. What a log does not keep comes back as default: a
/// violation of a cycle that was not violated. Topics it does not know are passed over.
///
///     LogReader log(path);
///     LogEntry entry;
///     while (log.Next(entry)) { if (const auto* cycle = std::get_if<rt::CycleRecord>(&entry)) ...
///     }
///
/// Threads: one thread. Real-time: no. Errors: InputError with file, offset and cause when the
/// bytes are not a log, whatever they are; EnvironmentError when the file cannot be read.
class LogReader {
 public:
  explicit LogReader(const std::filesystem::path& path);
  /// Of bytes in memory, which must outlive the reader. @param name  for error texts.
  LogReader(std::span<const std::byte> bytes, const std::string& name);
  ~LogReader();

  /// Gives the next entry. @returns false, with `entry` as it was, at the end.
  bool Next(LogEntry& entry);

  /// About the run. Known from the start.
  [[nodiscard]] const RunInfo& run() const;
  /// Whether the run was killed before the log was finished. Known from the start.
  [[nodiscard]] bool truncated() const;
  /// Messages read so far, those passed over included.
  [[nodiscard]] std::uint64_t message_count() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::record

#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "record/log_encoder.h"
#include "record/log_files.h"
#include "twin/record/cycle_record.h"
#include "twin/record/log_records.h"
#include "twin/record/log_split.h"
#include "twin/record/mcap_writer.h"
#include "twin/record/scene_record.h"

namespace twin::record {

/// Writes a log into one file, or one after the other (LogSplit). A file is completed by a thread
/// of its own while the next is written, since that waits for the disk.
///
/// Threads: one thread. Real-time: no. Errors: EnvironmentError; that of a file's completion comes
/// with a later cycle, or from Finish(). After an error only destruction is permitted.
class LogWriter {
 public:
  /// Creates the first file.
  LogWriter(const std::filesystem::path& path, const RunInfo& run, const LogSplit& split,
            std::size_t chunk_bytes);

  void Add(const CycleRecord& record);
  void Add(const TickRecord& record) { file_->encoder.Add(record); }
  void Add(const SceneRecord& record) { file_->encoder.Add(record); }
  void Add(const PlanRecord& record) { file_->encoder.Add(record); }
  void Add(Time at, std::string_view kind, std::string_view text) {
    file_->encoder.Add(at, kind, text);
  }

  /// Writes the open chunk.
  void Flush() { file_->mcap.Flush(); }
  /// Completes the files. @returns messages and bytes of all, also of those that were removed.
  McapTotals Finish();

 private:
  struct File {
    File(const std::filesystem::path& path, const McapWriterOptions& options, const RunInfo& run)
        : mcap(path, options), encoder(mcap, run) {}
    McapWriter mcap;
    LogEncoder encoder;
  };

  [[nodiscard]] std::unique_ptr<File> Create(std::vector<std::uint32_t> first_sequences) const;
  [[nodiscard]] bool IsFull(Time at) const;
  /// Completes a file, and removes those that are too many.
  McapTotals Complete(std::unique_ptr<File> file, std::size_t number) const;
  /// Begins the next file.
  void GoOn();
  /// Adds a completed file to the totals.
  void Count(const McapTotals& totals);

  const std::filesystem::path path_;
  const RunInfo run_;
  const LogSplit split_;
  const std::size_t chunk_bytes_;
  const LogFiles files_;
  std::size_t number_ = 0;     ///< of the open file; 0 without a split
  std::optional<Time> begin_;  ///< first cycle of the open file
  McapTotals totals_;
  std::unique_ptr<File> file_;
  std::future<McapTotals> completing_;  ///< last: its end is awaited before the rest goes
};

}  // namespace twin::record

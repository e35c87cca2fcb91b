#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "twin/core/time.h"

namespace twin::record {

/// How a log lies in files: without a time and a size in one, a.mcap; else split into a_0001.mcap,
/// a_0002.mcap and so on.
///
/// A file ends before the first cycle that is `time` later than its first cycle, or that finds
/// `bytes` written. With one producer (FullRing::kWait), what is put after a cycle is in its file;
/// with several, ticks, scenes and events near a split may be in the file beside it. Each file can
/// be read by itself. Sequence numbers of messages go on from file to file.
///
/// Files are numbered on from those that are there, so that a service that is started anew replaces
/// no log.
struct LogSplit {
  std::optional<Duration> time{};        ///< on the run's clock
  std::optional<std::uint64_t> bytes{};  ///< exceeded by a chunk and the file's index
  /// Ended files that stay, those of earlier runs among them; the oldest are removed. Absent: all.
  std::optional<std::size_t> keep{};
  /// Ended files, also a log's only one, are on the disk: for what cannot be run again.
  bool is_synced = false;

  [[nodiscard]] bool wanted() const noexcept { return time || bytes; }
};

/// Reads a time or a size: "1h", "90 s", "512MiB". @throws InputError for another text, and for
/// less than 0.1 s or 64 KiB.
[[nodiscard]] LogSplit ParseLogSplit(std::string_view text);

/// @returns the name of a log's file. @param number  from 1 on.
[[nodiscard]] std::filesystem::path LogPart(const std::filesystem::path& log, std::size_t number);

}  // namespace twin::record

#pragma once

#include <cstddef>
#include <filesystem>
#include <map>

namespace twin::record {

/// The files of a log that is split (LogPart), as they lie in its folder.
///
/// Threads: one at a time.
class LogFiles {
 public:
  explicit LogFiles(std::filesystem::path log);

  /// @returns a number above those of all files that are there, unfinished ones among them.
  /// @throws EnvironmentError if another process writes the newest.
  [[nodiscard]] std::size_t Next() const;

  /// Removes the oldest files with a number up to `last` until `keep` stay. Files that are no MCAP
  /// logs neither count nor go. @throws EnvironmentError naming a file that cannot be removed.
  void Prune(std::size_t keep, std::size_t last) const;

 private:
  /// By number; one that was never finished has its name .partial.
  [[nodiscard]] std::multimap<std::size_t, std::filesystem::path> Find() const;

  std::filesystem::path log_;
};

}  // namespace twin::record

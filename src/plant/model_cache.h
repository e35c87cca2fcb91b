#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace twin::plant {

/// Compiled models on disk, one file per key: `<key>.mjb`, a header line with length and
/// fingerprint of the payload, then the payload. A file appears under its name only when it is
/// whole.
///
/// Threads: one thread; several processes may share a folder.
class ModelCache {
 public:
  /// @param folder  made on the first Store().
  explicit ModelCache(std::filesystem::path folder);

  /// @returns the payload, or nothing when there is no entry.
  /// @throws EnvironmentError naming the file and the cure when the entry is corrupt or unreadable.
  [[nodiscard]] std::optional<std::string> Load(const std::string& key) const;

  /// Writes or replaces an entry. @throws EnvironmentError naming the folder when it cannot.
  void Store(const std::string& key, const std::string& payload) const;

 private:
  [[nodiscard]] std::filesystem::path FileOf(const std::string& key) const;
  std::filesystem::path folder_;
};

}  // namespace twin::plant

#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace twin::plant {

/// Compiled models on disk, one file per key: `<key>.mjb`, a header line with length and hash of
/// the payload, then the payload. A file gets its name only when complete. The cache is optional:
/// failures are silent here, and RepairModelCache() reports them.
///
/// Threads: one thread; several processes may share a folder.
class ModelCache {
 public:
  /// @param folder  created by the first Store().
  explicit ModelCache(std::filesystem::path folder);

  /// @returns the payload, or nullopt without a complete entry.
  [[nodiscard]] std::optional<std::string> Load(const std::string& key) const;

  /// Writes or replaces an entry if the folder is writable.
  void Store(const std::string& key, const std::string& payload) const;

 private:
  [[nodiscard]] std::filesystem::path FileOf(const std::string& key) const;
  std::filesystem::path folder_;
};

}  // namespace twin::plant

#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace twin::plant {

/// Compiled models on disk, one file per key: `<key>.mjb`, a header line with length and
/// fingerprint of the payload, then the payload. A file appears under its name only when it is
/// whole. A convenience: what it cannot do, one does without; RepairModelCache() tells of it.
///
/// Threads: one thread; several processes may share a folder.
class ModelCache {
 public:
  /// @param folder  made on the first Store().
  explicit ModelCache(std::filesystem::path folder);

  /// @returns the payload, or nothing when there is no entry, or none that is whole.
  [[nodiscard]] std::optional<std::string> Load(const std::string& key) const;

  /// Writes or replaces an entry, if the folder can be written.
  void Store(const std::string& key, const std::string& payload) const;

 private:
  [[nodiscard]] std::filesystem::path FileOf(const std::string& key) const;
  std::filesystem::path folder_;
};

}  // namespace twin::plant

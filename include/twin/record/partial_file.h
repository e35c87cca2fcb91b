#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace twin::record {

/// A file being written, as `<path>.partial`, that gets its own name only when it is whole.
///
/// Threads: one thread. Real-time: no. All failures are EnvironmentError with path, cause and cure.
class PartialFile {
 public:
  /// What happens to the `.partial` file when Commit() is never reached.
  enum class Leftover { kKeep, kRemove };

  /// Creates `<path>.partial`, or empties the one that is left from before. A `path` that is a
  /// directory is refused here, before anything is written: Commit() could not replace it.
  PartialFile(std::filesystem::path path, Leftover leftover);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// Appends `bytes` with one write(2), more only where the kernel takes less at once.
  void Write(std::span<const std::byte> bytes);

  /// Closes the file and renames it to its own name, over a file that has it.
  void Commit();

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
  std::filesystem::path partial_;
  Leftover leftover_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace twin::record

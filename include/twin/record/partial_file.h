#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>

#include "twin/record/partial_output.h"

namespace twin::record {

/// A file being written as `<path>.partial`; it gets its own name when complete. Other writers are
/// locked out (PartialOutput).
///
/// Threads: one thread. Real-time: no. Failures are EnvironmentError with path, cause and cure,
/// unless stated otherwise.
class PartialFile {
 public:
  /// Fate of the `.partial` file without Commit().
  enum class Leftover : std::uint8_t { kKeep, kRemove };

  /// Identifies files of one kind, so that no other file is overwritten.
  struct Kind {
    std::string_view name{};             ///< "an MCAP log"
    std::span<const std::byte> magic{};  ///< first bytes; empty: any file is replaced
  };

  /// Creates `<path>.partial`, or empties an old one. Refuses a `path` that exists and is not a
  /// regular file before anything is written, because Commit() could not, or must not, replace it.
  /// @throws InputError if either file exists and is neither empty nor of this kind.
  PartialFile(std::filesystem::path path, Leftover leftover, const Kind& kind);
  PartialFile(std::filesystem::path path, Leftover leftover)
      : PartialFile(std::move(path), leftover, Kind()) {}

  /// Appends `bytes` with one write(2), or several if the kernel takes less at once.
  void Write(std::span<const std::byte> bytes);

  /// Closes the file and renames it to its own name, replacing an existing file.
  void Commit();

  /// As Commit(), after the file's bytes are on the disk; then so is its name. A loss of power
  /// afterwards leaves the file whole.
  void CommitSynced();

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
  PartialOutput output_;
  std::uint64_t size_ = 0;
};

}  // namespace twin::record

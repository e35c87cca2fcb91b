#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>

#include "twin/record/partial_output.h"

namespace twin::record {

/// A file being written, as `<path>.partial`, that gets its own name only when it is whole. Nobody
/// else writes it meanwhile (PartialOutput).
///
/// Threads: one thread. Real-time: no. All failures are EnvironmentError with path, cause and cure,
/// unless it says otherwise.
class PartialFile {
 public:
  /// What happens to the `.partial` file when Commit() is never reached.
  enum class Leftover : std::uint8_t { kKeep, kRemove };

  /// By what files of a kind are known, so that no other is overwritten.
  struct Kind {
    std::string_view name{};             ///< "an MCAP log"
    std::span<const std::byte> magic{};  ///< what each begins with; empty: any file is replaced
  };

  /// Creates `<path>.partial`, or empties the one that is left from before. A `path` that is there
  /// and no regular file is refused here, before anything is written: Commit() could not, or must
  /// not, replace it. @throws InputError when either is there, and neither empty nor of this kind.
  PartialFile(std::filesystem::path path, Leftover leftover, const Kind& kind);
  PartialFile(std::filesystem::path path, Leftover leftover)
      : PartialFile(std::move(path), leftover, Kind()) {}

  /// Appends `bytes` with one write(2), more only where the kernel takes less at once.
  void Write(std::span<const std::byte> bytes);

  /// Closes the file and renames it to its own name, over a file that has it.
  void Commit();

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
  PartialOutput output_;
  std::uint64_t size_ = 0;
};

}  // namespace twin::record

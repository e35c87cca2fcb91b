#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace twin::record::mcap {

/// Random-access bytes for an MCAP reader.
class Source {
 public:
  virtual ~Source() = default;

  /// Length when the source was opened.
  [[nodiscard]] virtual std::uint64_t size() const = 0;

  /// Fills `out` from `offset`.
  /// @returns the number of bytes read; less than requested only at the end.
  /// @throws EnvironmentError if the file cannot be read.
  virtual std::size_t ReadAt(std::uint64_t offset, std::span<std::byte> out) = 0;
};

/// @throws InputError if `path` is not a file; EnvironmentError if it cannot be opened.
[[nodiscard]] std::unique_ptr<Source> OpenFile(const std::filesystem::path& path);

/// Reads from `bytes`, which must outlive the source.
[[nodiscard]] std::unique_ptr<Source> OpenMemory(std::span<const std::byte> bytes);

}  // namespace twin::record::mcap

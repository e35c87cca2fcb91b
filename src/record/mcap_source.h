#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace twin::record::mcap {

/// Bytes that an MCAP reader reads, at random offsets.
class Source {
 public:
  virtual ~Source() = default;

  /// Length when the source was opened.
  [[nodiscard]] virtual std::uint64_t size() const = 0;

  /// Fills `out` from `offset` on.
  /// @returns how many bytes were there; fewer than asked for only at the end.
  /// @throws EnvironmentError when the file cannot be read.
  virtual std::size_t ReadAt(std::uint64_t offset, std::span<std::byte> out) = 0;
};

/// @throws InputError when `path` names no file; EnvironmentError when it cannot be opened.
[[nodiscard]] std::unique_ptr<Source> OpenFile(const std::filesystem::path& path);

/// Reads from `bytes`, which must outlive the source.
[[nodiscard]] std::unique_ptr<Source> OpenMemory(std::span<const std::byte> bytes);

}  // namespace twin::record::mcap

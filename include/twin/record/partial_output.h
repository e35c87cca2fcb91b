#pragma once

#include <cstdint>
#include <filesystem>

namespace twin::record {

/// A future file or folder, as `<path>.partial`. Its lock excludes other writers for its lifetime:
/// of two writers to one name the second is refused.
///
/// Not locked if the file system supports no locks.
///
/// Threads: one thread. Real-time: no.
class PartialOutput {
 public:
  enum class Kind : std::uint8_t { kFile, kFolder };

  /// Creates the partial output, or opens an old one unchanged.
  /// @throws EnvironmentError if another process writes it, or it cannot be created.
  PartialOutput(std::filesystem::path path, Kind kind);
  /// Removes an unpublished file or empty folder, unless Keep() was called.
  ~PartialOutput();
  PartialOutput(const PartialOutput&) = delete;
  PartialOutput& operator=(const PartialOutput&) = delete;

  [[nodiscard]] const std::filesystem::path& partial() const noexcept { return partial_; }
  /// @returns the descriptor that holds the lock, for reading and writing a file; a process that
  /// inherits it holds the lock too.
  [[nodiscard]] int lock() const noexcept { return lock_; }

  /// Keeps the partial output even if it is not published.
  void Keep() noexcept { keeps_ = true; }
  /// Reverses Keep().
  void Remove() noexcept { keeps_ = false; }

  /// Renames it to its name, replacing an existing file or empty folder.
  /// @throws EnvironmentError if the system refuses, or another process removed the partial output.
  void Publish();

  /// @returns true if the partial output still exists and is ours.
  [[nodiscard]] bool IsOurs() const noexcept;

 private:
  /// @returns 0, or the errno of opening it.
  int Open(Kind kind);
  void Close() noexcept;

  std::filesystem::path path_;
  std::filesystem::path partial_;
  int lock_ = -1;  ///< descriptor of the partial output, open for reading and writing
  bool keeps_ = false;
};

}  // namespace twin::record

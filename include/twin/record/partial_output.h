#pragma once

#include <cstdint>
#include <filesystem>

namespace twin::record {

/// What is to become a file or a folder, as `<path>.partial`, locked against other writers as long
/// as this lives: of two that write into one name the second is refused.
///
/// Where the file system knows no locks, one writes without.
///
/// Threads: one thread. Real-time: no.
class PartialOutput {
 public:
  enum class Kind : std::uint8_t { kFile, kFolder };

  /// Makes the partial one, or takes the one that is left from before, as it is.
  /// @throws EnvironmentError when another writes it, or it cannot be made.
  PartialOutput(std::filesystem::path path, Kind kind);
  /// Removes what has not got its name and is not to be kept: a file, or a folder that is empty.
  ~PartialOutput();
  PartialOutput(const PartialOutput&) = delete;
  PartialOutput& operator=(const PartialOutput&) = delete;

  [[nodiscard]] const std::filesystem::path& partial() const noexcept { return partial_; }
  /// @returns what holds the lock, by which a file can be read and written; a process that inherits
  /// it holds it too.
  [[nodiscard]] int lock() const noexcept { return lock_; }

  /// The partial one stays, whether or not it gets its name.
  void Keep() noexcept { keeps_ = true; }
  /// It goes with this again, as it does unless Keep() was called.
  void Remove() noexcept { keeps_ = false; }

  /// Gives it its name, in place of an older file or empty folder.
  /// @throws EnvironmentError when the system refuses, or another took the partial one away.
  void Publish();

  /// @returns whether the partial one is still there, and this one's.
  [[nodiscard]] bool IsOurs() const noexcept;

 private:
  /// @returns 0, or why it cannot be opened.
  int Open(Kind kind);
  void Close() noexcept;

  std::filesystem::path path_;
  std::filesystem::path partial_;
  int lock_ = -1;  ///< descriptor of the partial one, open for reading and writing
  bool keeps_ = false;
};

}  // namespace twin::record

#pragma once

#include <filesystem>

namespace twin::golden {

/// Excludes other approvals into a folder of cases for its lifetime, from other processes and other
/// locks. No effect on file systems without locks.
class GoldensLock {
 public:
  /// @throws EnvironmentError naming the folder if it is locked or cannot be opened.
  explicit GoldensLock(const std::filesystem::path& goldens);
  ~GoldensLock();
  GoldensLock(const GoldensLock&) = delete;
  GoldensLock& operator=(const GoldensLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace twin::golden

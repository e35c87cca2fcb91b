#pragma once

#include <filesystem>

namespace twin::golden {

/// Keeps others from approving into a folder of cases for as long as it lives, be it in other
/// processes or by another lock. Where the file system knows no locks, it does nothing.
class GoldensLock {
 public:
  /// @throws EnvironmentError naming the folder when another holds it, or it cannot be opened.
  explicit GoldensLock(const std::filesystem::path& goldens);
  ~GoldensLock();
  GoldensLock(const GoldensLock&) = delete;
  GoldensLock& operator=(const GoldensLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace twin::golden

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "twin/golden/comparison.h"
#include "twin/golden/golden.h"

namespace twin::golden {

/// Result of an approval.
struct Approved {
  Golden golden;
  bool changed = true;  ///< false: everything was already approved, and nothing is written
};

/// Approves a run. If its pictures look like the approved ones (Compare() passes), these stay, so
/// that many approvals cannot drift, and only new hashes are added. Otherwise, and for other views,
/// its pictures and hashes replace the old ones.
/// @param old  the previous golden; nullopt without one.
/// @param reason  in the user's words. @param version  of the program.
/// @throws InputError if the reason is blank; EnvironmentError as Compare.
[[nodiscard]] Approved Approve(const std::optional<Golden>& old, const Evidence& evidence,
                               const std::string& reason, const std::string& version);

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

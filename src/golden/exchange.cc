#include "golden/golden_files.h"

#include <fcntl.h>
#include <stdio.h>

#include <cerrno>
#include <system_error>

namespace twin::golden {
namespace {

namespace fs = std::filesystem;

fs::path AsideOf(fs::path folder) {
  return folder += ".replaced";
}

/// @returns false if the file system cannot exchange. @throws fs::filesystem_error on failure.
bool ExchangeAtOnce(const fs::path& made, const fs::path& folder) {
  if (::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, folder.c_str(), RENAME_EXCHANGE) == 0) {
    return true;
  }
  if (errno == ENOSYS || errno == EINVAL || errno == EOPNOTSUPP) return false;
  throw fs::filesystem_error("exchange", made, folder, {errno, std::generic_category()});
}

void ExchangeInSteps(const fs::path& made, const fs::path& folder) {
  const fs::path aside = AsideOf(folder);
  fs::remove_all(aside);
  fs::rename(folder, aside);
  try {
    fs::rename(made, folder);
  } catch (const fs::filesystem_error&) {
    fs::rename(aside, folder);
    throw;
  }
}

}  // namespace

fs::path PartialOf(fs::path folder) {
  return folder += ".partial";
}

fs::path WholeOf(const fs::path& folder) {
  const fs::path aside = AsideOf(folder);
  return !fs::exists(folder) && fs::exists(aside) ? aside : folder;
}

void Exchange(const fs::path& made, const fs::path& folder) {
  const fs::path whole = WholeOf(folder);
  if (whole != folder) fs::rename(whole, folder);
  if (!fs::exists(folder)) {
    fs::rename(made, folder);
    return;
  }
  if (!ExchangeAtOnce(made, folder)) ExchangeInSteps(made, folder);
  // The new golden is in place; remains of the old one are harmless.
  std::error_code ignored;
  fs::remove_all(made, ignored);
  fs::remove_all(AsideOf(folder), ignored);
}

}  // namespace twin::golden

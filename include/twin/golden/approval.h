#pragma once

#include <optional>
#include <string>

#include "twin/golden/comparison.h"
#include "twin/golden/golden.h"

namespace twin::golden {

/// What an approval makes of a golden.
struct Approved {
  Golden golden;
  bool changed = true;  ///< else everything was approved before, and nothing need be written
};

/// Takes a run as right. Pictures that look the same as those approved (Compare() passes) stay what
/// they are, so that many approvals cannot drift away: only hashes that are not known are added.
/// Pictures that do not, or of other views, replace the old ones, and so do their hashes.
/// @param old  what was approved until now; absent: nothing.
/// @param reason  in the user's words. @param version  of the program.
/// @throws InputError when the reason is blank; EnvironmentError as Compare.
[[nodiscard]] Approved Approve(const std::optional<Golden>& old, const Evidence& evidence,
                               const std::string& reason, const std::string& version);

}  // namespace twin::golden

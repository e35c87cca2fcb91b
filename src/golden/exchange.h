#pragma once

#include <filesystem>

namespace twin::golden {

/// What a golden's folder is called until it is whole.
[[nodiscard]] std::filesystem::path PartialOf(std::filesystem::path folder);

/// Where what was approved of a case is: its folder, or, when an exchange in two steps was killed
/// between them, the one that was put aside. @returns `folder` when there is neither.
[[nodiscard]] std::filesystem::path WholeOf(const std::filesystem::path& folder);

/// Puts `made` where `folder` is, which need not be there, and removes what was there: in one step,
/// so that whenever the program is killed the one or the other is there. File systems that cannot
/// exchange need two steps, with the old folder put aside between them: see WholeOf().
/// @throws std::filesystem::filesystem_error; `folder` is as it was then.
void Exchange(const std::filesystem::path& made, const std::filesystem::path& folder);

}  // namespace twin::golden

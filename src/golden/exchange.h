#pragma once

#include <filesystem>

namespace twin::golden {

/// Path of a golden's folder until it is complete.
[[nodiscard]] std::filesystem::path PartialOf(std::filesystem::path folder);

/// Path of a case's approved golden: its folder, or the one put aside if a two-step exchange was
/// killed between its steps. @returns `folder` if neither exists.
[[nodiscard]] std::filesystem::path WholeOf(const std::filesystem::path& folder);

/// Moves `made` to `folder`, which need not exist, and removes the old one. Done in one step, so
/// that a kill at any time leaves one of them. File systems without exchange need two steps and put
/// the old folder aside between them: see WholeOf().
/// @throws std::filesystem::filesystem_error; `folder` is then unchanged.
void Exchange(const std::filesystem::path& made, const std::filesystem::path& folder);

}  // namespace twin::golden

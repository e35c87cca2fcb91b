#pragma once

#include <filesystem>
#include <string>

#include "twin/golden/golden.h"

// golden.yaml: everything of a golden but its pictures.
namespace twin::golden {

[[nodiscard]] std::string TextOf(const Golden& golden);

/// Reads what TextOf() wrote. The key pictures have their frames, and nothing else.
/// @throws InputError naming the file, and the line where there is one.
[[nodiscard]] Golden ReadGoldenText(const std::filesystem::path& path);

}  // namespace twin::golden

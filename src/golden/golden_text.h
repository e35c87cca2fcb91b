#pragma once

#include <filesystem>
#include <string>

#include "twin/golden/golden.h"

// golden.yaml: all data of a golden except its pictures.
namespace twin::golden {

[[nodiscard]] std::string TextOf(const Golden& golden);

/// Reads the text of TextOf(). The key pictures have only their frames.
/// @throws InputError naming the file and, if known, the line.
[[nodiscard]] Golden ReadGoldenText(const std::filesystem::path& path);

}  // namespace twin::golden

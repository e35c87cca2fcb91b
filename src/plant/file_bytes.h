#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "twin/core/content_hash.h"

namespace twin::plant {

/// @returns the whole file. @throws InputError naming the file and its kind `what` if not readable.
[[nodiscard]] std::string ReadFileBytes(const std::filesystem::path& file, std::string_view what);

}  // namespace twin::plant

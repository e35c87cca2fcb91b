#pragma once

#include <filesystem>
#include <string_view>

namespace twin::rt {

/// @param path  a search path as in $PATH. @returns the program's file; empty when there is none.
[[nodiscard]] std::filesystem::path FindProgram(std::string_view name, std::string_view path);

/// @throws EnvironmentError with `cure` when the program is not in `path`.
void RequireProgram(std::string_view name, std::string_view path, std::string_view cure);

}  // namespace twin::rt

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace twin::scenario {

/// The folders below models/robots that have `file`, by name.
[[nodiscard]] std::vector<std::string> FoldersWith(const std::filesystem::path& robots,
                                                   const char* file);

/// @param subject  what the message begins with: "robot.model:".
/// @throws InputError listing the names when `name` is none of them.
void RequireFolder(const std::filesystem::path& robots, std::string_view name, const char* file,
                   std::string_view subject);

}  // namespace twin::scenario

#include "scenario/robot_folders.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"

namespace twin::scenario {

std::vector<std::string> FoldersWith(const std::filesystem::path& robots, const char* file) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(robots, error)) {
    if (std::filesystem::exists(entry.path() / file, error)) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

void RequireFolder(const std::filesystem::path& robots, std::string_view name, const char* file,
                   std::string_view subject) {
  const std::vector<std::string> names = FoldersWith(robots, file);
  if (std::ranges::find(names, name) != names.end()) return;
  throw InputError(fmt::format("{} \"{}\" is unknown; {} has: {}", subject, name, robots.string(),
                               fmt::join(names, ", ")));
}

}  // namespace twin::scenario

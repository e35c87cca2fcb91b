#include "twin/rt/find_program.h"

#include <unistd.h>

#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::rt {

std::filesystem::path FindProgram(std::string_view name, std::string_view path) {
  while (!path.empty()) {
    const auto colon = path.find(':');
    std::filesystem::path file = std::filesystem::path(path.substr(0, colon)) / name;
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error) && access(file.c_str(), X_OK) == 0) {
      return file;
    }
    path = colon == std::string_view::npos ? std::string_view() : path.substr(colon + 1);
  }
  return {};
}

void RequireProgram(std::string_view name, std::string_view path, std::string_view cure) {
  if (!FindProgram(name, path).empty()) return;
  throw EnvironmentError(fmt::format("the program {} is not installed; {}", name, cure));
}

}  // namespace twin::rt

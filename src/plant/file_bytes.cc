#include "plant/file_bytes.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::plant {

std::string ReadFileBytes(const std::filesystem::path& file, std::string_view what) {
  errno = 0;
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);  // an error for a folder
  std::ifstream stream(file, std::ios::binary);
  if (!error && stream) {
    std::string bytes(size, '\0');
    if (stream.read(bytes.data(), static_cast<std::streamsize>(size))) return bytes;
  }
  throw InputError(fmt::format("{}: cannot read {}: {}", file.string(), what,
                               error ? error.message() : std::strerror(errno)));
}

}  // namespace twin::plant

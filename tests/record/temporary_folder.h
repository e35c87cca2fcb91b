#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

namespace twin::record {

using test::ReadText;
using test::TemporaryFolder;

inline std::vector<std::byte> ReadBytes(const std::filesystem::path& path) {
  const std::string text = ReadText(path);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace twin::record

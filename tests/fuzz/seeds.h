#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace twin::test {

/// What fuzzing starts from, by name.
using Seeds = std::map<std::string, std::vector<std::byte>>;

/// The seeds of a target. @param target  a folder of tests/fuzz/corpus.
inline Seeds SeedsOf(const std::string& target) {
  Seeds seeds;
  const std::filesystem::path folder =
      std::filesystem::path(TWIN_SOURCE_DIR) / "tests/fuzz/corpus" / target;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    std::vector<std::byte>& bytes = seeds[entry.path().stem().string()];
    std::ranges::transform(text, std::back_inserter(bytes),
                           [](char c) { return static_cast<std::byte>(c); });
  }
  return seeds;
}

}  // namespace twin::test

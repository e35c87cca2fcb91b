#include "sweep/left_aside.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace twin::sweep {

namespace fs = std::filesystem;

void AddressSet::Sort() {
  std::ranges::sort(numbers_);
}

bool AddressSet::Holds(const std::string& address) const {
  return std::ranges::binary_search(numbers_, NumberOf(address));
}

AddressSet::Number AddressSet::NumberOf(const std::string& address) {
  constexpr std::size_t kDigits = 16;
  constexpr int kHexadecimal = 16;
  Number number{};
  for (std::size_t i = 0; i < number.size() && i * kDigits < address.size(); ++i) {
    const std::string_view digits = std::string_view(address).substr(i * kDigits, kDigits);
    std::from_chars(digits.data(), digits.data() + digits.size(), number[i], kHexadecimal);
  }
  return number;
}

LeftAside CountLeftAside(const fs::path& out, const AddressSet& read,
                         const AddressSet& not_needed) {
  LeftAside left;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(out / "runs", none)) {
    if (entry.path().extension() != ".json") continue;
    const std::string address = entry.path().stem().string();
    if (read.Holds(address)) continue;
    if (not_needed.Holds(address)) {
      ++left.not_needed;
      continue;
    }
    const std::optional<Result> result = ReadResult(entry.path(), address);
    ++(result && result->version != TWIN_VERSION ? left.other_version : left.other);
  }
  return left;
}

std::string LeftAside::Text() const {
  std::string text;
  const auto add = [&text](std::uint64_t count, std::string_view what) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  add(other_version, "of another version of the program");
  add(not_needed, "of points that ended before");
  add(other, "of another sweep or other models");
  return text;
}

}  // namespace twin::sweep

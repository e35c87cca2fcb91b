#include "twin/record/log_split.h"

#include <array>
#include <chrono>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/quantity.h"

namespace twin::record {
namespace {

constexpr Duration kLeastTime = std::chrono::milliseconds(100);
constexpr std::uint64_t kLeastBytes = 64 * 1024;
constexpr double kMostBytes = 1e15;

struct Unit {
  std::string_view name;
  double bytes;
};
constexpr std::array kUnits{Unit{"KiB", 0x1p10}, Unit{"MiB", 0x1p20}, Unit{"GiB", 0x1p30},
                            Unit{"kB", 1e3},     Unit{"MB", 1e6},     Unit{"GB", 1e9}};

/// @returns the size in bytes; nothing without a unit of sizes.
std::optional<double> SizeOf(std::string_view text) {
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    text.remove_suffix(unit.name.size());
    if (text.ends_with(' ')) text.remove_suffix(1);
    return ParseNumber(text) * unit.bytes;
  }
  return std::nullopt;
}

Duration TimeOf(std::string_view text) {
  if (!text.ends_with('h')) return ParseDuration(text);
  text.remove_suffix(1);
  if (text.ends_with(' ')) text.remove_suffix(1);
  return ParseDuration(fmt::format("{} s", 3600 * ParseNumber(text)));
}

}  // namespace

LogSplit ParseLogSplit(std::string_view text) {
  try {
    LogSplit split;
    if (const std::optional<double> bytes = SizeOf(text)) {
      if (*bytes >= kLeastBytes && *bytes <= kMostBytes) {
        split.bytes = static_cast<std::uint64_t>(*bytes);
      }
    } else if (const Duration time = TimeOf(text); time >= kLeastTime) {
      split.time = time;
    }
    if (split.wanted()) return split;
  } catch (const InputError&) {
    // Told below.
  }
  throw InputError(fmt::format(
      "\"{}\" is neither a time of at least 0.1 s nor a size of at least 64 KiB; write it like 1h, "
      "90 s or 512MiB",
      text));
}

std::filesystem::path LogPart(const std::filesystem::path& log, std::size_t number) {
  std::filesystem::path name = log.stem();
  name += fmt::format("_{:04}", number);
  name += log.extension();
  return log.parent_path() / name;
}

}  // namespace twin::record

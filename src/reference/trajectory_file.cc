#include "twin/reference/trajectory_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::reference {
namespace {

constexpr std::size_t kColumns = 1 + kJoints;
constexpr std::array<std::string_view, kColumns> kColumnNames{"time", "q1", "q2", "q3",
                                                              "q4",   "q5", "q6", "q7"};
constexpr std::string_view kHeader = "time,q1,q2,q3,q4,q5,q6,q7";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr double kLongestSeconds = 86400;

/// No joint turns further than this, rad.
constexpr double kLargestAngle = 2 * std::numbers::pi;

std::string_view Trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Text from the file for a message: short, and printable whatever was in the file.
std::string Quoted(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string shown = "'";
  for (const char c : text.substr(0, kShown)) {
    const auto code = static_cast<unsigned char>(c);
    shown += (code < 0x20 || code >= 0x7F) ? fmt::format("\\x{:02x}", code) : std::string(1, c);
  }
  shown += text.size() > kShown ? "...'" : "'";
  return shown;
}

/// Cuts a line into its fields; `count` tells how many there are, of which at most kColumns are
/// kept.
struct Fields {
  std::array<std::string_view, kColumns> text{};
  std::size_t count = 0;
};

Fields Split(std::string_view line) {
  Fields fields;
  while (true) {
    const auto comma = line.find(',');
    if (fields.count < kColumns) fields.text[fields.count] = Trimmed(line.substr(0, comma));
    ++fields.count;
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

double ParseNumber(std::string_view text, const std::string& where, std::size_t column) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec == std::errc{} && result.ptr == end && std::isfinite(value)) return value;
  throw InputError(
      fmt::format("{}: column {} is {}; it must be a finite number of {}, with a "
                  "decimal point",
                  where, kColumnNames[column], Quoted(text), column == 0 ? "seconds" : "rad"));
}

Waypoint ParseLine(std::string_view line, std::string where) {
  const Fields fields = Split(line);
  if (fields.count != kColumns) {
    throw InputError(fmt::format("{}: {} field{} in {}; {} are needed ({})", where, fields.count,
                                 fields.count == 1 ? "" : "s", Quoted(line), kColumns, kHeader));
  }
  Waypoint waypoint;
  const double time_s = ParseNumber(fields.text[0], where, 0);
  if (!(time_s >= 0 && time_s <= kLongestSeconds)) {
    throw InputError(fmt::format("{}: column time is {} s; it must lie in [0, {}] s", where, time_s,
                                 kLongestSeconds));
  }
  waypoint.at = FromSeconds(time_s);
  for (std::size_t j = 0; j < kJoints; ++j) {
    waypoint.q[j] = ParseNumber(fields.text[j + 1], where, j + 1);
    if (std::abs(waypoint.q[j]) <= kLargestAngle) continue;
    throw InputError(
        fmt::format("{}: column {} is {} rad, more than a whole turn; positions are in "
                    "rad, not in degrees",
                    where, kColumnNames[j + 1], waypoint.q[j]));
  }
  waypoint.where = std::move(where);
  return waypoint;
}

void CheckTime(const Waypoint& waypoint, const std::vector<Waypoint>& before) {
  const double time_s = ToSeconds(*waypoint.at);
  if (before.empty()) {
    if (*waypoint.at == Duration::zero()) return;
    throw InputError(
        fmt::format("{}: column time is {} s; the first point's time must be 0 s "
                    "(subtract {} s from the column)",
                    waypoint.where, time_s, time_s));
  }
  const double last_s = ToSeconds(*before.back().at);
  if (*waypoint.at > *before.back().at) return;
  throw InputError(
      fmt::format("{}: column time is {} s, not after the {} s of the line before; "
                  "times must rise",
                  waypoint.where, time_s, last_s));
}

void CheckHeader(std::string_view line, const std::string& where) {
  const Fields fields = Split(line);
  if (fields.count == kColumns && fields.text == kColumnNames) return;
  throw InputError(fmt::format("{}: the header is {}; it must be '{}' (time in s, q in rad)", where,
                               Quoted(line), kHeader));
}

std::ifstream Open(const std::filesystem::path& path) {
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(path, error);
  if (!is_file) {
    throw InputError(fmt::format("{}: not a file that can be read{}", path.string(),
                                 error ? " (" + error.message() + ")" : ""));
  }
  const auto size = std::filesystem::file_size(path, error);
  if (!error && size > kMaxTrajectoryFileBytes) {
    throw InputError(
        fmt::format("{}: {} bytes; a trajectory file may have at most {} (use fewer "
                    "points)",
                    path.string(), size, kMaxTrajectoryFileBytes));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw InputError(fmt::format("{}: cannot be opened; check its permissions", path.string()));
  }
  return file;
}

}  // namespace

std::vector<Waypoint> ReadWaypointsCsv(const std::filesystem::path& path) {
  std::ifstream file = Open(path);
  const std::string name = path.filename().string();
  std::vector<Waypoint> waypoints;
  std::string text;
  std::size_t line_number = 0;
  std::size_t empty_line = 0;
  while (std::getline(file, text)) {
    ++line_number;
    std::string_view line = text;
    if (line_number == 1 && line.starts_with(kByteOrderMark)) {
      line.remove_prefix(kByteOrderMark.size());
    }
    if (line.ends_with('\r')) line.remove_suffix(1);
    std::string where = fmt::format("{}:{}", name, line_number);
    if (line_number == 1) {
      CheckHeader(line, where);
      continue;
    }
    if (Trimmed(line).empty()) {
      if (empty_line == 0) empty_line = line_number;
      continue;
    }
    if (empty_line != 0) {
      throw InputError(
          fmt::format("{}:{}: an empty line between points; remove it", name, empty_line));
    }
    Waypoint waypoint = ParseLine(line, std::move(where));
    CheckTime(waypoint, waypoints);
    waypoints.push_back(std::move(waypoint));
  }
  if (file.bad()) throw InputError(fmt::format("{}: reading failed", path.string()));
  if (waypoints.empty()) {
    throw InputError(fmt::format("{}: no points; wanted is the header '{}' and one point per line",
                                 path.string(), kHeader));
  }
  return waypoints;
}

}  // namespace twin::reference

#include "twin/reference/trajectory.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/csv_lines.h"
#include "twin/core/error.h"

namespace twin::reference {
namespace {

constexpr std::size_t kColumns = 1 + kJoints;
constexpr std::array<std::string_view, kColumns> kColumnNames{"time", "q1", "q2", "q3",
                                                              "q4",   "q5", "q6", "q7"};
constexpr CsvFormat kFormat{kColumnNames, "time in s, q in rad", "points"};
constexpr double kLongestSeconds = 86400;

/// Largest joint angle, rad.
constexpr double kLargestAngle = 2 * std::numbers::pi;

Waypoint ParseRow(const CsvLines& lines) {
  Waypoint waypoint;
  waypoint.where = lines.where();
  const double time_s = lines.Number(0, "seconds");
  if (!(time_s >= 0 && time_s <= kLongestSeconds)) {
    throw InputError(fmt::format("{}: column time is {} s; it must lie in [0, {}] s",
                                 waypoint.where, time_s, kLongestSeconds));
  }
  waypoint.at = FromSeconds(time_s);
  for (std::size_t j = 0; j < kJoints; ++j) {
    waypoint.q[j] = lines.Number(j + 1, "rad");
    if (std::abs(waypoint.q[j]) <= kLargestAngle) continue;
    throw InputError(
        fmt::format("{}: column {} is {} rad, more than a whole turn; positions are in "
                    "rad, not in degrees",
                    waypoint.where, kColumnNames[j + 1], waypoint.q[j]));
  }
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

}  // namespace

std::vector<Waypoint> ReadWaypointsCsv(const std::filesystem::path& path) {
  std::ifstream file = OpenTextFile(path, kMaxTrajectoryFileBytes, "a trajectory file");
  std::vector<Waypoint> waypoints;
  CsvLines lines(file, path.filename().string(), kFormat);
  while (lines.Next()) {
    Waypoint waypoint = ParseRow(lines);
    CheckTime(waypoint, waypoints);
    waypoints.push_back(std::move(waypoint));
  }
  if (waypoints.empty()) {
    throw InputError(fmt::format("{}: no points; wanted is the header '{}' and one point per line",
                                 path.string(), fmt::join(kColumnNames, ",")));
  }
  return waypoints;
}

}  // namespace twin::reference

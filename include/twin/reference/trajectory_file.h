#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "twin/reference/trajectory.h"

namespace twin::reference {

/// Largest accepted trajectory file, bytes.
inline constexpr std::uintmax_t kMaxTrajectoryFileBytes = std::uintmax_t{64} << 20;

/// Reads timed waypoints from a CSV file: the header line `time,q1,q2,q3,q4,q5,q6,q7`, then one
/// point per line, time in seconds from the start (rounded to nanoseconds, the first 0, strictly
/// increasing) and joint positions in rad. Numbers use a decimal point in any locale. Blanks around
/// a field, CRLF line ends, a byte order mark and empty lines at the end are accepted.
///
/// Each waypoint's `where` is file name and line.
///
/// @throws InputError naming file, line, column, the text found and the expected format, when: the
/// file is not regular, not readable or larger than kMaxTrajectoryFileBytes; the header differs; a
/// line has a wrong number of fields; a field is not a finite number; times do not increase from 0
/// or exceed a day; an empty line stands between points; there is no point.
[[nodiscard]] std::vector<Waypoint> ReadWaypointsCsv(const std::filesystem::path& path);

}  // namespace twin::reference

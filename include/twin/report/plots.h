#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "twin/core/limits.h"

namespace twin::report {

/// Names of the files, in order. A run gets either jerk.svg or torques.svg, and viability.svg only
/// with a viability filter.
inline constexpr std::array<const char*, 7> kPlotFiles{
    "joints.svg",  "tracking.svg", "velocities.svg", "jerk.svg",
    "torques.svg", "served.svg",   "viability.svg"};

/// Draws a log as SVG with gnuplot into `folder`, creating it if it is missing:
///   joints.svg      q and q_d of each joint, with its limits; under torques q and q_ext
///   tracking.svg    q_d - q of each joint, the tracking error; under torques q_ext - q, because
///                   the robot has no reference then
///   velocities.svg  dq and dq_d of each joint, with its limits; under torques dq and dq_ext
///   jerk.svg        dddq_d of each joint, with its limits; not under torques
///   torques.svg     tau_J and tau_J_d of each joint; under torques only
///   served.svg      cycles served and held, commands dropped, d_EXT, success rate
///   viability.svg   with a viability filter: the smallest joint margin, and the joints whose
///                   commands the filter changed
/// A dotted line with a number marks the start of each of several motions. A line in every panel
/// marks an error that ended a motion; the titles name it. Files have at most some 100 kB for a log
/// of any length: of the samples at one place, the lowest and the highest are drawn, so that no
/// peak is lost. The same log gives the same bytes, with the same version of gnuplot. Existing
/// files are replaced; each is `.partial` until it is complete.
///
/// Threads: one thread. Not real-time: runs gnuplot from PATH and waits.
/// @param log  written by record::Recorder; the log of a killed run is drawn up to its end.
/// @returns the paths of the files, in order.
/// @throws InputError if the log is damaged or has no cycle, or the limits are invalid;
/// EnvironmentError if gnuplot is missing or fails, or a file cannot be read or written.
std::vector<std::filesystem::path> WritePlots(const std::filesystem::path& log,
                                              const JointLimits& limits,
                                              const std::filesystem::path& folder);

}  // namespace twin::report

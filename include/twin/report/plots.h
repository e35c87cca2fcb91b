#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "twin/core/limits.h"

namespace twin::report {

/// Names of the files that may be drawn, in their order: of jerk.svg and torques.svg a run gets
/// one, and viability.svg one with a viability filter.
inline constexpr std::array<const char*, 7> kPlotFiles{
    "joints.svg",  "tracking.svg", "velocities.svg", "jerk.svg",
    "torques.svg", "served.svg",   "viability.svg"};

/// Draws a log as SVG, with gnuplot, into `folder`, which is made when missing:
///   joints.svg      q and q_d of each joint, between its limits; under torques q and q_ext
///   tracking.svg    q_d - q of each joint: what the measured arm is behind the reference; under
///                   torques q_ext - q, as the robot then has no reference
///   velocities.svg  dq and dq_d of each joint, against its limits; under torques dq and dq_ext
///   jerk.svg        dddq_d of each joint, against its limits; not under torques
///   torques.svg     tau_J and tau_J_d of each joint; under torques only
///   served.svg      cycles served and held, commands dropped, d_EXT, success rate
///   viability.svg   behind a viability filter: the least of the joints' margins, and when it kept
///   a
///                   joint's command back
/// Of several motions each begins at a dotted line with its number.
/// When an error ended a motion, a line in every panel marks when, and the titles say which.
/// A log of any length gives files of at most some 100 kB: of the samples that fall into the same
/// place, the lowest and the highest are drawn, so that no peak is lost. The same log gives the
/// same bytes, with the same version of gnuplot. Files of these names are replaced; each is
/// `.partial` until it is whole.
///
/// Threads: one thread. Real-time: no; runs gnuplot from PATH and waits for it.
/// @param log  as record::Recorder wrote it; that of a killed run is drawn as far as it goes.
/// @returns the paths of the files, in their order.
/// @throws InputError when the log is damaged or holds no cycle, or the limits are not valid;
/// EnvironmentError when gnuplot is missing or fails, or a file cannot be read or written.
std::vector<std::filesystem::path> WritePlots(const std::filesystem::path& log,
                                              const JointLimits& limits,
                                              const std::filesystem::path& folder);

}  // namespace twin::report

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

namespace twin::report {

/// How far the measured arm was from where its workstation wanted it at that time: q_ext - q, with
/// q_ext the deposited target of the planned trajectory. A few milliseconds of delay are part of
/// it, velocity times delay; a reference that does not follow its target (a low-pass behind the
/// reference generator, a robot that stopped) shows as much more.
struct Deviation {
  double largest = 0;     ///< magnitude, rad
  std::size_t joint = 0;  ///< of the largest, 0..6
  double at = 0;          ///< of the largest, s
  double rms = 0;         ///< of that joint, over the motion, rad
};

/// Measures a log, in one pass. Threads: one thread. Real-time: no.
/// @returns nothing when the log holds no target of joints.
/// @throws InputError when it is damaged; EnvironmentError when it cannot be read.
[[nodiscard]] std::optional<Deviation> MeasureDeviation(const std::filesystem::path& log);

}  // namespace twin::report

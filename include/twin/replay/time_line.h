#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "twin/core/time.h"
#include "twin/render/snapshots.h"

namespace twin::replay {

/// Of one film: 22 h at 25 frames a second. More are a damaged log, and would fill the memory.
inline constexpr std::size_t kMostFrames = 2'000'000;

/// Part of a run that a film shows, and its speed.
struct TimeLine {
  std::optional<Time> from{};   ///< of the run; nullopt: its first record
  std::optional<Time> until{};  ///< last instant; nullopt: its last record
  double speed = 1;             ///< seconds of the run per second of the film, in [0.01, 100]
  int fps = 25;                 ///< of the film, in [1, 240]

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Instants of a film's frames:
///   t_k = from + speed k / fps,   k = 0, 1, ... while t_k <= until.
/// @param first, last  of the run's records.
/// @returns from 1 to kMostFrames. @throws InputError if the time line is invalid, lies outside the
/// run (gives the run's range) or has too many frames.
[[nodiscard]] std::vector<Time> FrameTimes(Time first, Time last, const TimeLine& time_line);

/// The recorded scenes at these instants: for each the first scene at or after it, without
/// interpolation; after the last scene, that one. At the instants of a run's video these are its
/// frames.
/// @param fps  of the film. @pre scenes.size() > 0; times rise.
[[nodiscard]] render::Snapshots SnapshotsAt(const render::Snapshots& scenes,
                                            std::span<const Time> times, int fps);

/// The recorded scenes in the interval [from - length, from).
[[nodiscard]] render::Snapshots SnapshotsBefore(const render::Snapshots& scenes, Time from,
                                                Duration length);

}  // namespace twin::replay

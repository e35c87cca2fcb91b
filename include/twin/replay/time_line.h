#pragma once

#include <optional>
#include <span>
#include <vector>

#include "twin/core/time.h"
#include "twin/render/snapshots.h"

namespace twin::replay {

/// Which instants of a run a film shows, and how fast it shows them.
struct TimeLine {
  std::optional<Time> from{};   ///< of the run; absent: its first record
  std::optional<Time> until{};  ///< the last that may be shown; absent: its last record
  double speed = 1;             ///< seconds of the run in a second of the film, in [0.01, 100]
  int fps = 25;                 ///< of the film, in [1, 240]

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// The instants that a film's frames show:
///   t_k = from + speed k / fps,   k = 0, 1, ... while t_k <= until.
/// @param first, last  of the run's records.
/// @returns at least one. @throws InputError when the time line is not valid, or shows nothing of
/// the run (says what there is).
[[nodiscard]] std::vector<Time> FrameTimes(Time first, Time last, const TimeLine& time_line);

/// What was recorded at these instants: for each the first scene at or after it, nothing between
/// them made up; after the last scene that one. With the instants at which a run's video was due,
/// these are its frames.
/// @param fps  of the film. @pre scenes.size() > 0; times rise.
[[nodiscard]] render::Snapshots SnapshotsAt(const render::Snapshots& scenes,
                                            std::span<const Time> times, int fps);

/// What was recorded in the time before an instant: at from - length, or later, and before from.
[[nodiscard]] render::Snapshots SnapshotsBefore(const render::Snapshots& scenes, Time from,
                                                Duration length);

}  // namespace twin::replay

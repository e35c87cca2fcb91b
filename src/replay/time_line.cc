#include "twin/replay/time_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "twin/core/error.h"

namespace twin::replay {
namespace {

double Seconds(Time time) {
  return ToSeconds(time.time_since_epoch());
}

/// Integer nanoseconds as in the run's camera, so that at speed 1 the instants are the same.
Duration Since(std::size_t frame, const TimeLine& line) {
  const std::int64_t film_ns = static_cast<std::int64_t>(frame) * std::nano::den / line.fps;
  if (line.speed == 1) return Duration(film_ns);
  return Duration(std::llround(static_cast<double>(film_ns) * line.speed));
}

}  // namespace

void TimeLine::Validate() const {
  RequireInRange("speed", speed, 0.01, 100);
  RequireInRange("fps", fps, 1, 240);
  if (from && until && *until < *from) {
    throw InputError(fmt::format("the film would end at {} s, before it begins at {} s",
                                 Seconds(*until), Seconds(*from)));
  }
}

std::vector<Time> FrameTimes(Time first, Time last, const TimeLine& time_line) {
  time_line.Validate();
  const Time from = time_line.from.value_or(first);
  const Time until = std::min(time_line.until.value_or(last), last);
  if (from > last || until < first) {
    throw InputError(fmt::format(
        "nothing was recorded between {} and {} s; the log holds {} to {} s", Seconds(from),
        Seconds(time_line.until.value_or(last)), Seconds(first), Seconds(last)));
  }
  const double film = Seconds(until) - Seconds(from);
  if (film / time_line.speed * time_line.fps > kMostFrames) {
    throw InputError(fmt::format(
        "the film of {} to {} s would have more than {} frames; show a part of the run (--from, "
        "--until), or fewer frames a second",
        Seconds(from), Seconds(until), kMostFrames));
  }
  std::vector<Time> times{from};
  for (Time t = from + Since(1, time_line); t <= until; t = from + Since(times.size(), time_line)) {
    times.push_back(t);
  }
  return times;
}

render::Snapshots SnapshotsAt(const render::Snapshots& scenes, std::span<const Time> times,
                              int fps) {
  render::Snapshots shown(fps, scenes.qpos_size());
  shown.Reserve(times.size());
  std::size_t i = 0;
  for (const Time time : times) {
    while (i + 1 < scenes.size() && scenes.time(i) < time) ++i;
    shown.Append(scenes.scene(i));
  }
  return shown;
}

render::Snapshots SnapshotsBefore(const render::Snapshots& scenes, Time from, Duration length) {
  render::Snapshots before(scenes.fps(), scenes.qpos_size());
  for (std::size_t i = 0; i < scenes.size() && scenes.time(i) < from; ++i) {
    if (scenes.time(i) >= from - length) before.Append(scenes.scene(i));
  }
  return before;
}

}  // namespace twin::replay

#pragma once

#include <cstdint>

#include "twin/render/film.h"
#include "twin/render/frame_painter.h"
#include "twin/render/image.h"

namespace twin::replay {

/// Still pictures of what was planned and what came of it: edges are smoothed, overlays but those
/// of forces and contacts taken away.
///
/// Threads: one at a time, any. Errors: those of render::FramePainter.
class PlanPictures {
 public:
  /// @param film  what it refers to must outlive this. @pre it has a frame.
  PlanPictures(const render::Film& film, render::FilmSettings settings);

  /// When it was planned; a plan is one of the film's goals, as in the following.
  [[nodiscard]] render::Image Before(const render::PlannedGoal& plan);
  /// The same with its goal as a ghost and its way as a line.
  [[nodiscard]] render::Image Planned(const render::PlannedGoal& plan);
  /// When it was done.
  [[nodiscard]] render::Image Done(const render::PlannedGoal& plan);

 private:
  const render::Snapshots& snapshots_;
  render::FramePainter painter_;
};

/// The last frame at or before an instant; the first one when there is none.
[[nodiscard]] std::size_t FrameAt(const render::Snapshots& snapshots, Time at);

}  // namespace twin::replay

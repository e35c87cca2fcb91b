#pragma once

#include <cstdint>

#include "twin/render/film.h"
#include "twin/render/frame_painter.h"
#include "twin/render/image.h"

namespace twin::replay {

/// Still pictures of plans and their results, with smoothed edges and without overlays except
/// forces and contacts.
///
/// Threads: any, one at a time. Errors: those of render::FramePainter.
class PlanPictures {
 public:
  /// @param film  its references must outlive this object. @pre it has a frame.
  PlanPictures(const render::Film& film, render::FilmSettings settings);

  /// At planning time. @param plan  here and below: one of the film's goals.
  [[nodiscard]] render::Image Before(const render::PlannedGoal& plan);
  /// As Before(), with the goal as a ghost and the path as a line.
  [[nodiscard]] render::Image Planned(const render::PlannedGoal& plan);
  /// When the plan was done.
  [[nodiscard]] render::Image Done(const render::PlannedGoal& plan);

 private:
  const render::Snapshots& snapshots_;
  render::FramePainter painter_;
};

/// The last frame at or before an instant; the first frame if there is none.
[[nodiscard]] std::size_t FrameAt(const render::Snapshots& snapshots, Time at);

}  // namespace twin::replay

#pragma once

#include <cstddef>
#include <memory>

#include "twin/render/film.h"
#include "twin/render/image.h"

namespace twin::render {

/// Draws the frames of a film, in any order. What a frame shows depends on the film and its number
/// alone, so several painters on several threads make one film; determinism as Renderer's.
///
/// Threads: one at a time, any.
class FramePainter {
 public:
  /// @param film  model and snapshots must outlive this.
  /// @throws InputError for settings out of range, and a camera, body or joint that the model does
  /// not have; EnvironmentError as Renderer.
  FramePainter(const Film& film, const FilmSettings& settings);
  ~FramePainter();
  FramePainter(FramePainter&&) noexcept;
  FramePainter& operator=(FramePainter&&) = delete;

  /// @returns the picture, with insets and overlays. @pre frame < film.snapshots->size(), as the
  /// following.
  [[nodiscard]] Image Paint(std::size_t frame);
  /// As Paint(), with this goal in place of the film's, whatever its time and the overlays.
  /// @throws InputError when the model lacks what it names.
  [[nodiscard]] Image Paint(std::size_t frame, const PlannedGoal& goal);
  /// @returns distances along the main view's axis; neither insets nor overlays.
  [[nodiscard]] DepthImage Depth(std::size_t frame);
  /// @returns the body seen in each pixel of the main view; neither insets nor overlays.
  [[nodiscard]] SegmentationImage Segment(std::size_t frame);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::render

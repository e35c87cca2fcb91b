#pragma once

#include <cstddef>
#include <memory>

#include "twin/render/film.h"
#include "twin/render/image.h"

namespace twin::render {

/// Draws the frames of a film in any order. A frame depends only on the film and its number, so
/// several painters on several threads can draw one film; deterministic as Renderer.
///
/// Threads: one at a time, any.
class FramePainter {
 public:
  /// @param film  its model and snapshots must outlive this object.
  /// @throws InputError for settings out of range, or a camera, body or joint missing in the model;
  /// EnvironmentError as Renderer.
  FramePainter(const Film& film, const FilmSettings& settings);
  ~FramePainter();
  FramePainter(FramePainter&&) noexcept;
  FramePainter& operator=(FramePainter&&) = delete;

  /// @returns the picture, with insets and overlays. @pre here and below: frame <
  /// film.snapshots->size().
  [[nodiscard]] Image Paint(std::size_t frame);
  /// As Paint(), with this goal instead of the film's, regardless of its time and the overlays.
  /// @throws InputError if the model lacks a named body.
  [[nodiscard]] Image Paint(std::size_t frame, const PlannedGoal& goal);
  /// @returns distances along the main view's axis, without insets and overlays.
  [[nodiscard]] DepthImage Depth(std::size_t frame);
  /// @returns the main view's own projection.
  [[nodiscard]] PinholeCamera Camera(std::size_t frame);
  /// @returns the body seen in each pixel of the main view, without insets and overlays.
  [[nodiscard]] SegmentationImage Segment(std::size_t frame);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::render

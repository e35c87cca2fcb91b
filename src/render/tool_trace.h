#pragma once

#include <mujoco/mujoco.h>

#include <cstddef>
#include <vector>

#include "render/drawn_model.h"
#include "render/marks.h"
#include "twin/render/snapshots.h"

namespace twin::render {

/// Past path of the tool: the point between the fingers, or the flange without a hand.
class ToolTrace {
 public:
  ToolTrace() = default;
  /// @param before  snapshots before the frames; may be null.
  /// @throws InputError if the model has neither hand nor arm.
  ToolTrace(const DrawnModel& model, const Snapshots* before, const Snapshots& frames);

  /// Appends the path up to a frame. @param seconds  length of the trace.
  void Append(std::size_t frame, double seconds, const Colour& colour,
              std::vector<mjvGeom>& marks) const;

 private:
  struct Point {
    double at_s = 0;
    Vector3 p_W{};
  };
  void Follow(const DrawnModel& model, const Snapshots& snapshots);

  std::vector<Point> points_;  ///< those before the frames, then one per frame
  std::size_t before_ = 0;     ///< number of points before the frames
};

}  // namespace twin::render

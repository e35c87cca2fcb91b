#pragma once

#include <mujoco/mujoco.h>

#include <cstddef>
#include <vector>

#include "render/drawn_model.h"
#include "render/marks.h"
#include "twin/render/snapshots.h"

namespace twin::render {

/// Where the tool has been: between the fingers, or at the flange of an arm without a hand.
class ToolTrace {
 public:
  ToolTrace() = default;
  /// @param before  what came before the frames; may be null.
  /// @throws InputError when the model has neither hand nor arm.
  ToolTrace(const DrawnModel& model, const Snapshots* before, const Snapshots& frames);

  /// Appends the way up to a frame. @param seconds  how far back.
  void Append(std::size_t frame, double seconds, const Colour& colour,
              std::vector<mjvGeom>& marks) const;

 private:
  struct Point {
    double at_s = 0;
    Vector3 p_W{};
  };
  void Follow(const DrawnModel& model, const Snapshots& snapshots);

  std::vector<Point> points_;  ///< before the frames, then one for each
  std::size_t before_ = 0;     ///< how many are before them
};

}  // namespace twin::render

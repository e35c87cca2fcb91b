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
  /// @throws InputError when the model has neither hand nor arm.
  ToolTrace(const DrawnModel& model, const Snapshots& snapshots);

  /// Appends the way up to a frame. @param seconds  how far back.
  void Append(std::size_t frame, double seconds, const Colour& colour,
              std::vector<mjvGeom>& marks) const;

 private:
  struct Point {
    double at_s = 0;
    Vector3 p_W{};
  };
  std::vector<Point> points_;  ///< one for each frame
};

}  // namespace twin::render

#pragma once

#include <mujoco/mujoco.h>

#include <array>

#include "render/drawn_model.h"
#include "render/scene_renderer.h"

namespace twin::render {

/// Seven bars in the lower right corner, base to wrist from left to right. Each is a joint's range,
/// upper limit at the top, with a slider at its position; amber within a tenth of the range from a
/// limit, red within a fiftieth.
class JointBars {
 public:
  JointBars() = default;
  /// @throws InputError if the model has no arm.
  explicit JointBars(const DrawnModel& model);

  /// @pre scene's context is in use.
  void Draw(const mjData& data, const SceneRenderer& scene) const;

 private:
  struct Joint {
    int position = 0;  ///< in qpos
    double lower = 0;
    double upper = 0;
  };
  std::array<Joint, kJoints> joints_{};
};

}  // namespace twin::render

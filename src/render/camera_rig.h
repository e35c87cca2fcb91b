#pragma once

#include <mujoco/mujoco.h>

#include "render/drawn_model.h"
#include "render/scene_renderer.h"
#include "twin/core/time.h"
#include "twin/render/view.h"

namespace twin::render {

/// Positions a view's camera for a frame.
class CameraRig {
 public:
  /// @throws InputError if the model lacks the camera or body.
  CameraRig(const View& view, const DrawnModel& model);

  /// @param since  time since the film's start.
  void Aim(Duration since, const mjData& data, Shot& shot) const;

 private:
  View view_;
  int id_ = -1;  ///< of the camera, or of the body that is tracked or carries the camera
};

}  // namespace twin::render

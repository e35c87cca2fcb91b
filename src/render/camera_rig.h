#pragma once

#include <mujoco/mujoco.h>

#include "render/drawn_model.h"
#include "render/scene_renderer.h"
#include "twin/core/time.h"
#include "twin/render/view.h"

namespace twin::render {

/// Puts a view's camera where it belongs in a frame.
class CameraRig {
 public:
  /// @throws InputError for a camera or body that the model does not have.
  CameraRig(const View& view, const DrawnModel& model);

  /// @param since  the film's begin.
  void Aim(Duration since, const mjData& data, Shot& shot) const;

 private:
  View view_;
  int id_ = -1;  ///< of the camera, or the body that is followed or carries the camera
};

}  // namespace twin::render

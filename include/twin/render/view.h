#pragma once

#include <cstdint>
#include <string>

#include "twin/render/pinhole_camera.h"

namespace twin::render {

enum class ViewKind : std::uint8_t {
  kScene,     ///< a camera of the model, by name
  kOrbit,     ///< a camera that is fixed, or orbits a point of the world
  kTracking,  ///< a camera at a constant distance from a body
  kGripper,   ///< a camera on the flange, as users mount it: 7 cm beside its axis, facing the tool
};

/// Viewpoint of a film.
struct View {
  ViewKind kind = ViewKind::kOrbit;
  /// kScene: the camera; kTracking: the body; kGripper: what the names of the arm's bodies begin
  /// with, among several arms.
  std::string name;
  FreeCamera orbit;          ///< kOrbit, kTracking; for kTracking, lookat_m is relative to the body
  bool turns_along = false;  ///< kTracking: azimuth and lookat_m follow the body's rotation about z
  double turn_deg_per_s = 0;  ///< kOrbit, kTracking: of the azimuth, in run time; |.| <= 360

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

enum class Corner : std::uint8_t { kTopLeft, kTopRight, kBottomLeft, kBottomRight };

/// A second view inside the picture of the first; without ghosts of planned goals.
struct Inset {
  View view;
  Corner corner = Corner::kTopRight;
  double share = 0.3;  ///< of the picture's width and height, in [0.1, 0.5]
};

}  // namespace twin::render

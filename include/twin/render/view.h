#pragma once

#include <cstdint>
#include <string>

#include "twin/render/pinhole_camera.h"

namespace twin::render {

enum class ViewKind : std::uint8_t {
  kScene,     ///< a camera of the model, by its name
  kOrbit,     ///< a camera that stands, or turns round a point of the world
  kTracking,  ///< one that keeps its distance from a body
  kGripper,   ///< one on the flange, as users mount it: 7 cm beside its axis, towards the tool
};

/// From where a film is seen.
struct View {
  ViewKind kind = ViewKind::kOrbit;
  std::string name;  ///< kScene: the camera; kTracking: the body
  FreeCamera orbit;  ///< kOrbit, kTracking; of the latter, lookat_m is seen from the body
  bool turns_along =
      false;  ///< kTracking: azimuth and lookat_m are the body's, as it turns about z
  double turn_deg_per_s = 0;  ///< kOrbit, kTracking: of the azimuth, by the run's time; |.| <= 360

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

enum class Corner : std::uint8_t { kTopLeft, kTopRight, kBottomLeft, kBottomRight };

/// A second view within the picture of the first; without ghosts of planned goals.
struct Inset {
  View view;
  Corner corner = Corner::kTopRight;
  double share = 0.3;  ///< of the picture's width and height, in [0.1, 0.5]
};

}  // namespace twin::render

#include "cli/picture.h"

#include <numbers>

#include "twin/render/snapshots.h"

namespace twin::cli {

render::RenderSettings PictureOf(const scenario::RenderSection& wanted) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  render::RenderSettings settings;
  settings.width = wanted.width;
  settings.height = wanted.height;
  settings.camera = wanted.camera;
  settings.free_camera = {wanted.azimuth * kDegrees, wanted.elevation * kDegrees, wanted.distance,
                          wanted.lookat};
  return settings;
}

void CheckPicture(const scenario::Run& run, const scenario::RenderSection& wanted) {
  const render::Renderer renderer(run.connection().truth->model(), PictureOf(wanted));
}

}  // namespace twin::cli

#include "cli/picture.h"

#include <cstddef>
#include <numbers>

#include <fmt/format.h>

#include "cli/progress.h"

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

void CheckPicture(const backend::Connection& connection, const scenario::RenderSection& wanted) {
  const render::Renderer renderer(connection.truth->model(), PictureOf(wanted));
}

render::FilmSettings FilmOf(const scenario::RenderSection& wanted) {
  render::FilmSettings film;
  film.render = PictureOf(wanted);
  film.view.kind = wanted.camera.empty() ? render::ViewKind::kOrbit : render::ViewKind::kScene;
  film.view.name = wanted.camera;
  film.view.orbit = film.render.free_camera;
  return film;
}

render::ClipStats MakeClip(const render::Film& film, const scenario::RenderSection& wanted,
                           const ResultFolder& out, const InterruptGuard& interrupt,
                           const Clock& clock, bool quiet) {
  render::ClipSettings settings;
  settings.film = FilmOf(wanted);
  Progress progress("video", Progress::StyleOfStdout(quiet), clock);
  return render::RenderClip(film, settings, {out.video(), out.contact_sheet()}, clock,
                            [&](std::size_t done, std::size_t total) {
                              interrupt.ThrowIfInterrupted();
                              progress.Show(static_cast<double>(done) / static_cast<double>(total),
                                            fmt::format("{} of {} frames", done, total));
                            });
}

}  // namespace twin::cli

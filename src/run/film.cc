#include "twin/run/film.h"

#include <algorithm>
#include <numbers>
#include <string>
#include <string_view>

namespace twin::run {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

render::View ViewOf(const scenario::CameraSection& camera) {
  render::View view;
  view.orbit = {camera.azimuth * kDegrees, camera.elevation * kDegrees, camera.distance,
                camera.lookat};
  view.turn_deg_per_s = camera.turn * kDegrees;
  switch (camera.kind) {
    case scenario::CameraKind::kOrbit:
      view.kind = camera.track.empty() ? render::ViewKind::kOrbit : render::ViewKind::kTracking;
      view.name = camera.track;
      break;
    case scenario::CameraKind::kScene:
      view.kind = render::ViewKind::kScene;
      view.name = camera.name;
      break;
    case scenario::CameraKind::kGripper: view.kind = render::ViewKind::kGripper; break;
  }
  return view;
}

}  // namespace

render::Corner CornerOf(scenario::PictureCorner corner) {
  switch (corner) {
    case scenario::PictureCorner::kTopLeft: return render::Corner::kTopLeft;
    case scenario::PictureCorner::kTopRight: return render::Corner::kTopRight;
    case scenario::PictureCorner::kBottomLeft: return render::Corner::kBottomLeft;
    case scenario::PictureCorner::kBottomRight: break;
  }
  return render::Corner::kBottomRight;
}

render::View ViewFromText(std::string_view text, const render::View& otherwise) {
  constexpr std::string_view kTrack = "track:";
  // Near the followed body, and straight at it.
  constexpr render::FreeCamera kNear{
      .azimuth_deg = 142, .elevation_deg = -18, .distance_m = 0.9, .lookat_m = {}};
  if (text == scenario::kGripperCamera) {
    return {.kind = render::ViewKind::kGripper, .name = {}, .orbit = {}};
  }
  if (text.starts_with(kTrack)) {
    return {.kind = render::ViewKind::kTracking,
            .name = std::string(text.substr(kTrack.size())),
            .orbit = kNear};
  }
  if (text != "orbit") {
    return {.kind = render::ViewKind::kScene, .name = std::string(text), .orbit = {}};
  }
  if (otherwise.kind == render::ViewKind::kOrbit) return otherwise;
  return FilmOf(scenario::RenderSection()).view;
}

render::Overlays OverlaysOf(const std::vector<scenario::Overlay>& wanted) {
  const auto has = [&](scenario::Overlay overlay) {
    return std::find(wanted.begin(), wanted.end(), overlay) != wanted.end();
  };
  return {.text = has(scenario::Overlay::kText),
          .goal = has(scenario::Overlay::kGoal),
          .trace = has(scenario::Overlay::kTrace),
          .forces = has(scenario::Overlay::kForces),
          .contacts = has(scenario::Overlay::kContacts),
          .limits = has(scenario::Overlay::kLimits)};
}

render::FilmSettings Fine(render::FilmSettings film) {
  film.render.width = 1280;
  film.render.height = 720;
  film.render.samples = 4;
  film.render.shadow_size = 2048;
  return film;
}

render::FilmSettings FilmOf(const scenario::RenderSection& wanted) {
  render::FilmSettings film;
  film.render.width = wanted.width;
  film.render.height = wanted.height;
  film.view = ViewOf(wanted.camera);
  for (const scenario::InsetSection& inset : wanted.insets) {
    film.insets.push_back(
        {ViewOf(inset.camera), CornerOf(inset.corner), inset.share_percent / 100});
  }
  film.overlays = OverlaysOf(wanted.overlays);
  return film;
}

}  // namespace twin::run

#include "twin/run/film.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <numbers>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/render/frame_painter.h"

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

/// Of a body that is followed: near, and straight at it.
constexpr render::FreeCamera kNear{
    .azimuth_deg = 142, .elevation_deg = -18, .distance_m = 0.9, .lookat_m = {}};

render::View ViewFromText(std::string_view text, const render::View& otherwise) {
  constexpr std::string_view kTrack = "track:";
  if (text == scenario::kGripperCamera)
    return {.kind = render::ViewKind::kGripper, .name = {}, .orbit = {}};
  if (text.starts_with(kTrack)) {
    return {.kind = render::ViewKind::kTracking,
            .name = std::string(text.substr(kTrack.size())),
            .orbit = kNear};
  }
  if (text != "orbit") {
    return {.kind = render::ViewKind::kScene, .name = std::string(text), .orbit = {}};
  }
  if (otherwise.kind == render::ViewKind::kOrbit) return otherwise;
  const scenario::CameraSection usual;
  return FilmOf(scenario::RenderSection{.camera = usual}).view;
}

/// The angles and distances that were given.
void Turn(const FilmChoice& choice, render::View& view) {
  const bool given = choice.azimuth_deg || choice.elevation_deg || choice.distance ||
                     !choice.lookat.empty() || choice.turn_deg;
  if (!given) return;
  if (view.kind != render::ViewKind::kOrbit && view.kind != render::ViewKind::kTracking) {
    throw InputError(
        "--azimuth, --elevation, --distance, --lookat and --turn go with --camera orbit or "
        "--camera track:BODY: another camera stands where it is mounted");
  }
  render::FreeCamera& orbit = view.orbit;
  orbit.azimuth_deg = choice.azimuth_deg.value_or(orbit.azimuth_deg);
  orbit.elevation_deg = choice.elevation_deg.value_or(orbit.elevation_deg);
  orbit.distance_m = choice.distance.value_or(orbit.distance_m);
  if (!choice.lookat.empty())
    orbit.lookat_m = {choice.lookat[0], choice.lookat[1], choice.lookat[2]};
  view.turn_deg_per_s = choice.turn_deg.value_or(view.turn_deg_per_s);
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

void CheckPicture(const backend::Connection& connection, const scenario::RenderSection& wanted,
                  const std::filesystem::path& scenario) {
  const render::Snapshots none(wanted.fps, connection.truth->qpos_size());
  try {
    const render::FramePainter painter({&connection.truth->model(), &none}, FilmOf(wanted));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", scenario.string(), error.what()));
  }
}

render::ClipStats RenderClip(const render::ClipFrames& frames, const render::ClipPaths& paths,
                             const Clock& clock, Console& console) {
  render::ClipSettings settings;
  settings.render_threads =
      static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 16U));
  const Time begin = clock.Now();
  return render::RenderClip(
      frames, settings, paths, clock, [&](std::size_t done, std::size_t total) {
        console.ThrowIfInterrupted();
        const double rate = static_cast<double>(done) / ToSeconds(clock.Now() - begin);
        console.Show("video", static_cast<double>(done) / static_cast<double>(total),
                     fmt::format("{} of {} frames, {:.0f} frames/s", done, total, rate));
      });
}

render::Inset InsetFromText(std::string_view text, const render::View& otherwise) {
  const std::size_t at = text.find('@');
  render::Inset inset{.view = ViewFromText(text.substr(0, at), otherwise)};
  if (at == std::string_view::npos) return inset;
  for (const auto& [name, corner] : scenario::kPictureCornerNames) {
    if (name != text.substr(at + 1)) continue;
    inset.corner = CornerOf(corner);
    return inset;
  }
  throw InputError(fmt::format(
      "there is no corner {}; choose one of top_left, top_right, bottom_left, bottom_right",
      text.substr(at + 1)));
}

render::Overlays OverlaysFromText(std::string_view text) {
  std::vector<scenario::Overlay> overlays;
  if (text == "none") return OverlaysOf(overlays);
  while (true) {
    const std::string_view name = text.substr(0, text.find(','));
    const auto* const found = std::ranges::find(
        scenario::kOverlayNames, name, &std::pair<std::string_view, scenario::Overlay>::first);
    if (found == scenario::kOverlayNames.end()) {
      throw InputError(
          fmt::format("there is no {}; choose of text, goal, trace, forces, contacts, limits, with "
                      "commas between them, or none",
                      name));
    }
    overlays.push_back(found->second);
    if (name.size() == text.size()) return OverlaysOf(overlays);
    text.remove_prefix(name.size() + 1);
  }
}

void SetSizeFromText(std::string_view text, render::RenderSettings& settings) {
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, settings.width);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, settings.height);
    if (height.ec == std::errc() && height.ptr == end) return settings.Validate();
  }
  throw InputError(
      fmt::format("{} is no size; give WIDTHxHEIGHT in pixels, such as 1280x720", text));
}

render::FilmSettings FilmOf(const scenario::RenderSection& wanted, const FilmChoice& choice) {
  render::FilmSettings film = FilmOf(wanted);
  if (choice.camera) film.view = ViewFromText(*choice.camera, film.view);
  Turn(choice, film.view);
  if (!choice.insets.empty()) film.insets.clear();
  for (const std::string& inset : choice.insets) {
    if (inset != "none") film.insets.push_back(InsetFromText(inset, film.view));
  }
  if (choice.overlays) film.overlays = OverlaysFromText(*choice.overlays);
  if (choice.size) SetSizeFromText(*choice.size, film.render);
  film.Validate();
  return film;
}

}  // namespace twin::run

#include "twin/run/film_choice.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/run/film.h"

namespace twin::run {
namespace {

/// Of a body that is followed: near, and straight at it.
constexpr render::FreeCamera kNear{
    .azimuth_deg = 142, .elevation_deg = -18, .distance_m = 0.9, .lookat_m = {}};

render::View ViewOf(std::string_view text, const render::View& otherwise) {
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

render::Inset InsetFromText(std::string_view text, const render::View& otherwise) {
  const std::size_t at = text.find('@');
  render::Inset inset{.view = ViewOf(text.substr(0, at), otherwise)};
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
  if (choice.camera) film.view = ViewOf(*choice.camera, film.view);
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

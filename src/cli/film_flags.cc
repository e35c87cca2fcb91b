#include "cli/film_flags.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "cli/picture.h"
#include "twin/core/error.h"

namespace twin::cli {
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
void Turn(const FilmFlags& flags, render::View& view) {
  const bool given = flags.azimuth_deg || flags.elevation_deg || flags.distance ||
                     !flags.lookat.empty() || flags.turn_deg;
  if (!given) return;
  if (view.kind != render::ViewKind::kOrbit && view.kind != render::ViewKind::kTracking) {
    throw InputError(
        "--azimuth, --elevation, --distance, --lookat and --turn go with --camera orbit or "
        "--camera track:BODY: another camera stands where it is mounted");
  }
  render::FreeCamera& orbit = view.orbit;
  orbit.azimuth_deg = flags.azimuth_deg.value_or(orbit.azimuth_deg);
  orbit.elevation_deg = flags.elevation_deg.value_or(orbit.elevation_deg);
  orbit.distance_m = flags.distance.value_or(orbit.distance_m);
  if (!flags.lookat.empty()) orbit.lookat_m = {flags.lookat[0], flags.lookat[1], flags.lookat[2]};
  view.turn_deg_per_s = flags.turn_deg.value_or(view.turn_deg_per_s);
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

render::FilmSettings FilmOf(const scenario::RenderSection& wanted, const FilmFlags& flags) {
  render::FilmSettings film = FilmOf(wanted);
  if (flags.camera) film.view = ViewOf(*flags.camera, film.view);
  Turn(flags, film.view);
  if (!flags.insets.empty()) film.insets.clear();
  for (const std::string& inset : flags.insets) {
    if (inset != "none") film.insets.push_back(InsetFromText(inset, film.view));
  }
  if (flags.overlays) film.overlays = OverlaysFromText(*flags.overlays);
  if (flags.size) SetSizeFromText(*flags.size, film.render);
  film.Validate();
  return film;
}

}  // namespace twin::cli

#include "cli/film_flags.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "twin/core/integer.h"
#include "twin/run/film.h"

namespace twin::cli {
namespace {

/// Applies the angles and distances that were given.
void Turn(const FilmFlags& choice, render::View& view) {
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

/// @param otherwise  the view of the camera `orbit`, if that orbits. @throws InputError listing the
/// accepted words, as the next two.
render::Inset InsetFromText(std::string_view text, const render::View& otherwise) {
  const std::size_t at = text.find('@');
  render::Inset inset{.view = run::ViewFromText(text.substr(0, at), otherwise)};
  if (at == std::string_view::npos) return inset;
  for (const auto& [name, corner] : scenario::kPictureCornerNames) {
    if (name != text.substr(at + 1)) continue;
    inset.corner = run::CornerOf(corner);
    return inset;
  }
  throw InputError(fmt::format(
      "there is no corner {}; choose one of top_left, top_right, bottom_left, bottom_right",
      text.substr(at + 1)));
}

render::Overlays OverlaysFromText(std::string_view text) {
  std::vector<scenario::Overlay> overlays;
  for (bool is_last = text == "none"; !is_last;) {
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
    is_last = name.size() == text.size();
    if (!is_last) text.remove_prefix(name.size() + 1);
  }
  return run::OverlaysOf(overlays);
}

/// @throws InputError also for a size out of range.
render::RenderSettings SizeFromText(std::string_view text) {
  const std::size_t x = text.find('x');
  const auto width = ParseInteger<int>(text.substr(0, x));
  const auto height = ParseInteger<int>(text.substr(std::min(x, text.size() - 1) + 1));
  if (!width || !height) {
    throw InputError(
        fmt::format("{} is no size; give WIDTHxHEIGHT in pixels, such as 1280x720", text));
  }
  render::RenderSettings size;
  size.width = *width;
  size.height = *height;
  size.Validate();
  return size;
}

}  // namespace

render::FilmSettings FilmOf(const scenario::RenderSection& wanted, const FilmFlags& flags) {
  render::FilmSettings film = run::FilmOf(wanted);
  if (flags.camera) film.view = run::ViewFromText(*flags.camera, film.view);
  Turn(flags, film.view);
  if (!flags.insets.empty()) film.insets.clear();
  for (const std::string& inset : flags.insets) {
    if (inset != "none") film.insets.push_back(InsetFromText(inset, film.view));
  }
  film.overlays = flags.overlays.value_or(film.overlays);
  if (IsFine(flags.quality)) film = run::Fine(film);
  if (flags.size) {
    film.render.width = flags.size->width;
    film.render.height = flags.size->height;
  }
  film.Validate();
  return film;
}

void AddQuality(CLI::App& app, std::string& quality) {
  Add(app, "--quality draft|fine", quality,
      "fine: 1280x720, each pixel of four samples; draft: the scenario's size, one sample")
      ->check(CLI::IsMember({"draft", "fine"}).description(""))
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
      ->capture_default_str();
}

void AddFilm(CLI::App& app, FilmFlags& flags) {
  Add(app, "--camera CAMERA", flags.camera,
      "A camera of the scene by its name, orbit, track:BODY, or gripper");
  Add(app, "--azimuth DEG", flags.azimuth_deg, "orbit, track: direction in which it looks");
  Add(app, "--elevation DEG", flags.elevation_deg, "orbit, track: negative looks down");
  Add(app, "--distance M", flags.distance, "orbit, track: from what it looks at");
  Add(app, "--lookat X Y Z", flags.lookat, "orbit: point of the world; track: from the body")
      ->expected(3);
  Add(app, "--turn DEG/S", flags.turn_deg, "orbit, track: turns so fast, by the run's time");
  Add(app, "--inset CAMERA[@CORNER]", flags.insets,
      "A picture within the picture, such as gripper@bottom_left; may be repeated; none")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->each(Parsed("--inset", [](const std::string& text) {
        if (text != "none") static_cast<void>(InsetFromText(text, {}));
      }));
  AddParsed(app, "--overlays", "LIST", flags.overlays,
            "What is drawn over it, of text, goal, trace, forces, contacts, limits; none",
            &OverlaysFromText);
  AddQuality(app, flags.quality);
  AddParsed(app, "--size", "WxH", flags.size, "Of the picture, pixels, even", &SizeFromText);
}

}  // namespace twin::cli

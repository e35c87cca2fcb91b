#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/command.h"
#include "twin/core/error.h"
#include "twin/render/film.h"
#include "twin/scenario/render_section.h"

namespace twin::cli {

/// Flags of a film, in place of what the scenario's section render says.
struct FilmFlags {
  std::optional<std::string> camera;  ///< a scene's camera by name, orbit, track:BODY or gripper
  std::optional<double> azimuth_deg;
  std::optional<double> elevation_deg;
  std::optional<double> distance;   ///< m
  std::vector<double> lookat;       ///< x, y, z, m; empty: not given
  std::optional<double> turn_deg;   ///< per second
  std::vector<std::string> insets;  ///< CAMERA or CAMERA@CORNER; none takes all away
  std::optional<render::Overlays> overlays;
  std::string quality = "draft";
  std::optional<render::RenderSettings> size;  ///< width and height
};
void AddFilm(CLI::App& app, FilmFlags& flags);

/// Adds --quality. @param quality  must outlive the command.
void AddQuality(CLI::App& app, std::string& quality);
[[nodiscard]] inline bool IsFine(std::string_view quality) {
  return quality == "fine";
}

/// The scenario's film with the flags in its place. @throws InputError when an angle goes with a
/// camera that has none.
[[nodiscard]] render::FilmSettings FilmOf(const scenario::RenderSection& wanted,
                                          const FilmFlags& flags);

/// Runs `parse` on the text of an option; its InputError becomes an error of usage.
template <typename Parse>
auto Parsed(const std::string& option, Parse parse) {
  return [=](const std::string& text) {
    try {
      return parse(text);
    } catch (const InputError& error) {
      throw CLI::ValidationError(option, error.what());
    }
  };
}

/// Adds an option whose text `parse` converts. @param value  must outlive the command.
template <typename T>
CLI::Option* AddParsed(CLI::App& app, const std::string& name, const char* type,
                       std::optional<T>& value, const char* text, T (*parse)(std::string_view)) {
  const auto read = [&value, parsed = Parsed(name, parse)](const std::string& given) {
    value = parsed(given);
  };
  return app.add_option_function<std::string>(name, read, text)->type_name(type);
}

}  // namespace twin::cli

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/render/clip.h"
#include "twin/render/film.h"
#include "twin/run/console.h"
#include "twin/scenario/render_section.h"

namespace twin::run {

/// Convert a scenario's enumerators into the renderer's.
[[nodiscard]] render::Corner CornerOf(scenario::PictureCorner corner);
[[nodiscard]] render::Overlays OverlaysOf(const std::vector<scenario::Overlay>& wanted);

/// The film settings that a scenario's section render asks for.
[[nodiscard]] render::FilmSettings FilmOf(const scenario::RenderSection& wanted);

/// Draws one picture, before a run writes anything.
/// @pre connection.truth is not null.
/// @param scenario  its file, for messages.
/// @throws InputError naming it for a camera or body the scene does not have; EnvironmentError
/// without OSMesa.
void CheckPicture(const backend::Connection& connection, const scenario::RenderSection& wanted,
                  const std::filesystem::path& scenario);

/// Renders frames as a video, and a contact sheet of them, on one thread for each processor, and
/// shows the progress. @returns counts and times. @throws as render::RenderClip; Interrupted.
render::ClipStats RenderClip(const render::ClipFrames& frames, const render::ClipPaths& paths,
                             const Clock& clock, Console& console);

/// Film settings of the command line, which replace those of the scenario.
struct FilmChoice {
  std::optional<std::string> camera;  ///< a scene's camera by name, orbit, track:BODY or gripper
  std::optional<double> azimuth_deg;
  std::optional<double> elevation_deg;
  std::optional<double> distance;       ///< m
  std::vector<double> lookat;           ///< x, y, z, m; empty: not given
  std::optional<double> turn_deg;       ///< per second
  std::vector<std::string> insets;      ///< CAMERA or CAMERA@CORNER; none takes all away
  std::optional<std::string> overlays;  ///< names with commas between them, or none
  std::optional<std::string> size;      ///< WIDTHxHEIGHT, pixels
};

/// Parses the value of a flag. @throws InputError listing the accepted words.
[[nodiscard]] render::Overlays OverlaysFromText(std::string_view text);
/// As the above. @param otherwise  what the camera `orbit` shows, where it is one that orbits.
[[nodiscard]] render::Inset InsetFromText(std::string_view text, const render::View& otherwise);
/// As the above. @param settings  gets the size. @throws InputError also for one out of range.
void SetSizeFromText(std::string_view text, render::RenderSettings& settings);

/// The scenario's film with what was chosen in its place.
/// @throws InputError for what is none of the words that may stand there (names those), or when an
/// angle goes with a camera that has none.
[[nodiscard]] render::FilmSettings FilmOf(const scenario::RenderSection& wanted,
                                          const FilmChoice& choice);

}  // namespace twin::run

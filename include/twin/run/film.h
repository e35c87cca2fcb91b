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

/// A scenario's words in the renderer's.
[[nodiscard]] render::Corner CornerOf(scenario::PictureCorner corner);
[[nodiscard]] render::Overlays OverlaysOf(const std::vector<scenario::Overlay>& wanted);

/// What a scenario wants its film to look like.
[[nodiscard]] render::FilmSettings FilmOf(const scenario::RenderSection& wanted);

/// Tries the renderer once, before a run writes anything.
/// @pre connection.truth is not null.
/// @param scenario  the file that wants it, for messages.
/// @throws InputError naming it for a camera or body the scene does not have; EnvironmentError
/// without OSMesa.
void CheckPicture(const backend::Connection& connection, const scenario::RenderSection& wanted,
                  const std::filesystem::path& scenario);

/// Renders frames as a video, and a contact sheet of them, on one thread for each processor, and
/// shows how far that is. @returns what it took. @throws as render::RenderClip; Interrupted.
render::ClipStats RenderClip(const render::ClipFrames& frames, const render::ClipPaths& paths,
                             const Clock& clock, Console& console);

/// What a film should look like, where that differs from what its scenario says.
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

/// What a flag's words mean. @throws InputError naming those that may stand there.
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

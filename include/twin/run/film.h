#pragma once

#include <filesystem>
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

}  // namespace twin::run

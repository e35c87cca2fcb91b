#pragma once

#include <string_view>
#include <vector>

#include "twin/render/film.h"
#include "twin/scenario/render_section.h"

namespace twin::run {

/// Convert a scenario's enumerators into the renderer's.
[[nodiscard]] render::Corner CornerOf(scenario::PictureCorner corner);
[[nodiscard]] render::Overlays OverlaysOf(const std::vector<scenario::Overlay>& wanted);

/// The view that a user names: a camera of the scene, `orbit`, `track:BODY` or `gripper`.
/// @param otherwise  taken for `orbit` if it orbits, else the default orbit.
[[nodiscard]] render::View ViewFromText(std::string_view text, const render::View& otherwise);

/// The film settings that a scenario's section render asks for.
[[nodiscard]] render::FilmSettings FilmOf(const scenario::RenderSection& wanted);

/// The same in fine quality: 1280 x 720 pixels of four samples each, shadows of 2048 texels. About
/// four times the time.
[[nodiscard]] render::FilmSettings Fine(render::FilmSettings film);

}  // namespace twin::run

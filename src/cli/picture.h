#pragma once

#include "twin/render/renderer.h"
#include "twin/scenario/assembly.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// What a scenario wants to be shown, in the renderer's terms.
[[nodiscard]] render::RenderSettings PictureOf(const scenario::RenderSection& wanted);

/// Tries the renderer once, before a run writes anything.
/// @pre run.connection().truth is not null.
/// @throws InputError for a camera the scene does not have; EnvironmentError without OSMesa.
void CheckPicture(const scenario::Run& run, const scenario::RenderSection& wanted);

}  // namespace twin::cli

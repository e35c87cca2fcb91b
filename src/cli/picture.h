#pragma once

#include "cli/interrupt.h"
#include "cli/result_folder.h"
#include "twin/backend/registry.h"
#include "twin/core/clock.h"
#include "twin/render/clip.h"
#include "twin/render/renderer.h"
#include "twin/render/snapshots.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {

/// What a scenario wants to be shown, in the renderer's terms.
[[nodiscard]] render::RenderSettings PictureOf(const scenario::RenderSection& wanted);

/// Tries the renderer once, before a run writes anything.
/// @pre connection.truth is not null.
/// @throws InputError for a camera the scene does not have; EnvironmentError without OSMesa.
void CheckPicture(const backend::Connection& connection, const scenario::RenderSection& wanted);

/// Renders the snapshots of a run, at least one, as its video and contact sheet, and shows how far
/// that is. @returns what it took. @throws as render::RenderClip; Interrupted.
[[nodiscard]] render::ClipStats MakeClip(const mjModel_& model, const render::Snapshots& snapshots,
                                         const scenario::RenderSection& wanted,
                                         const ResultFolder& out, const InterruptGuard& interrupt,
                                         const Clock& clock, bool quiet);

}  // namespace twin::cli

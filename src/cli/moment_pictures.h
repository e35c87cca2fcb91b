#pragma once

#include <filesystem>
#include <vector>

#include "twin/application/application.h"
#include "twin/application/page.h"
#include "twin/render/renderer.h"
#include "twin/render/snapshots.h"

struct mjModel_;

namespace twin::cli {

/// Draws an application's moments, two pictures of each: <number>_<id>_plan.png and
/// <number>_<id>.png in `folder`, which is made when missing. What the arm looked like is taken
/// from the frame before.
/// @param model  the model the snapshots are of. @pre snapshots.size() > 0
/// @returns their paths. @throws what render::Renderer and render::WritePng throw.
[[nodiscard]] std::vector<application::MomentPictures> DrawMoments(
    const mjModel_& model, const render::Snapshots& snapshots,
    const std::vector<application::Moment>& moments, const render::RenderSettings& settings,
    const std::filesystem::path& folder);

}  // namespace twin::cli

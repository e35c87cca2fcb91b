#pragma once

#include <filesystem>
#include <vector>

#include "twin/application/application.h"
#include "twin/application/page.h"
#include "twin/render/film.h"

struct mjModel_;

namespace twin::cli {

/// Draws an application's moments, two pictures of each: <number>_<id>_plan.png and
/// <number>_<id>.png in `folder`, which is made when missing. What the arm looked like is taken
/// from the frame before. @param settings  smoothed edges are added, texts taken away.
/// @param model  the model the snapshots are of. @pre snapshots.size() > 0
/// @returns their paths. @throws what render::FramePainter and render::WritePng throw.
[[nodiscard]] std::vector<application::MomentPictures> DrawMoments(
    const mjModel_& model, const render::Snapshots& snapshots,
    const std::vector<application::Moment>& moments, render::FilmSettings settings,
    const std::filesystem::path& folder);

}  // namespace twin::cli

#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "cli/result_folder.h"
#include "twin/application/application.h"
#include "twin/application/page.h"
#include "twin/render/film.h"

namespace twin::cli {

/// Draws an application's snapshots, two pictures of each: <number>_<id>_plan.png and
/// <number>_<id>.png in `folder`, which is made when missing.
/// @param film  of the run; its goals are the snapshots'. @param settings  overlays are taken away.
/// @returns their paths. @throws what replay::PlanPictures and render::WritePng throw.
[[nodiscard]] std::vector<application::SnapshotPictures> DrawSnapshots(
    const render::Film& film, std::span<const application::Snapshot> snapshots,
    render::FilmSettings settings, const std::filesystem::path& folder);

/// Draws a planned motion: plan_initial.png, plan.png and plan_final.png. @param film  its only
/// goal is the plan's. @param settings, @throws as above.
void DrawPlannedMotion(const render::Film& film, render::FilmSettings settings,
                       const ResultFolder& out);

}  // namespace twin::cli

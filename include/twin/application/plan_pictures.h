#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "twin/application/application.h"
#include "twin/application/page.h"
#include "twin/record/log_records.h"
#include "twin/render/film.h"
#include "twin/run/result_folder.h"
#include "twin/run/run.h"
#include "twin/scenario/scenario.h"

// What was planned and carried out: in the log, and in pictures.
namespace twin::application {

/// What an application planned and carried out, for its log.
[[nodiscard]] record::PlanRecord PlanOf(const Snapshot& snapshot);

/// The same of a planned motion, from its run's beginning to the end. @pre the run is over.
[[nodiscard]] record::PlanRecord PlanOf(const run::Run& run, const scenario::Scenario& scenario,
                                        Time end);

/// Draws an application's snapshots, two pictures of each: <number>_<id>_plan.png and
/// <number>_<id>.png in `folder`, which is made when missing.
/// @param film  of the run; its goals are the snapshots'. @param settings  overlays are taken away.
/// @returns their paths. @throws what replay::PlanPictures and render::WritePng throw.
[[nodiscard]] std::vector<SnapshotPictures> DrawSnapshots(const render::Film& film,
                                                          std::span<const Snapshot> snapshots,
                                                          render::FilmSettings settings,
                                                          const std::filesystem::path& folder);

/// Draws a planned motion: plan_initial.png, plan.png and plan_final.png. @param film  its only
/// goal is the plan's. @param settings, @throws as above.
void DrawPlannedMotion(const render::Film& film, render::FilmSettings settings,
                       const run::ResultFolder& out);

}  // namespace twin::application

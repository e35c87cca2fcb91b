#include "cli/snapshot_pictures.h"

#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "twin/render/png.h"
#include "twin/replay/plan_pictures.h"

namespace twin::cli {
namespace {

render::FilmSettings Bare(render::FilmSettings settings) {
  settings.overlays = {.text = false};
  return settings;
}

}  // namespace

std::vector<application::SnapshotPictures> DrawSnapshots(
    const render::Film& film, std::span<const application::Snapshot> snapshots,
    render::FilmSettings settings, const std::filesystem::path& folder) {
  MakeFolder(folder);
  replay::PlanPictures pictures(film, Bare(std::move(settings)));
  std::vector<application::SnapshotPictures> pairs;
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    const std::string name = fmt::format("{}_{}", i + 1, snapshots[i].id);
    pairs.push_back({.planned = folder / (name + "_plan.png"), .done = folder / (name + ".png")});
    render::WritePng(pairs[i].planned, pictures.Planned(film.goals[i]));
    render::WritePng(pairs[i].done, pictures.Done(film.goals[i]));
  }
  return pairs;
}

void DrawPlannedMotion(const render::Film& film, render::FilmSettings settings,
                       const ResultFolder& out) {
  replay::PlanPictures pictures(film, Bare(std::move(settings)));
  const render::PlannedGoal& plan = film.goals.front();
  render::WritePng(out.plan_initial(), pictures.Before(plan));
  render::WritePng(out.plan(), pictures.Planned(plan));
  render::WritePng(out.plan_final(), pictures.Done(plan));
}

}  // namespace twin::cli

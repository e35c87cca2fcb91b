#include "twin/application/plan_pictures.h"

#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "twin/application/end_effector_path.h"
#include "twin/render/png.h"
#include "twin/render/renderer.h"
#include "twin/replay/plan_pictures.h"

namespace twin::application {
namespace {

render::FilmSettings Bare(render::FilmSettings settings) {
  settings.overlays = {.text = false};
  return settings;
}

}  // namespace

static_assert(render::Ghost::kMostPoints <= record::PlanRecord::kMostPoints);

record::PlanRecord PlanOf(const Snapshot& snapshot) {
  return {.id = snapshot.id,
          .caption = snapshot.caption,
          .from = snapshot.planned,
          .until = snapshot.done,
          .q = snapshot.goal,
          .way = snapshot.way,
          .object = snapshot.object,
          .O_T_object = snapshot.O_T_object};
}

record::PlanRecord PlanOf(const run::Run& run, const scenario::Scenario& scenario, Time end) {
  const Transform F_T_EE = run.robot().F_T_EE(scenario.onboard.NE_T_EE);
  return {.id = "plan",
          .caption = "Around what stands there to the goal",
          .from = Time(),
          .until = end,
          .q = run.trajectory().goal(),
          .way = EndEffectorPath(run.trajectory(), F_T_EE)};
}

std::vector<SnapshotPictures> DrawSnapshots(const render::Film& film,
                                            std::span<const Snapshot> snapshots,
                                            render::FilmSettings settings,
                                            const std::filesystem::path& folder) {
  run::MakeFolder(folder);
  replay::PlanPictures pictures(film, Bare(std::move(settings)));
  std::vector<SnapshotPictures> pairs;
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    const std::string name = fmt::format("{}_{}", i + 1, snapshots[i].id);
    pairs.push_back({.planned = folder / (name + "_plan.png"), .done = folder / (name + ".png")});
    render::WritePng(pairs[i].planned, pictures.Planned(film.goals[i]));
    render::WritePng(pairs[i].done, pictures.Done(film.goals[i]));
  }
  return pairs;
}

void DrawPlannedMotion(const render::Film& film, render::FilmSettings settings,
                       const run::ResultFolder& out) {
  replay::PlanPictures pictures(film, Bare(std::move(settings)));
  const render::PlannedGoal& plan = film.goals.front();
  render::WritePng(out.plan_initial(), pictures.Before(plan));
  render::WritePng(out.plan(), pictures.Planned(plan));
  render::WritePng(out.plan_final(), pictures.Done(plan));
}

}  // namespace twin::application

#include "twin/replay/plan_pictures.h"

#include <utility>

namespace twin::replay {
namespace {

render::FilmSettings ForStills(render::FilmSettings settings) {
  settings.render.samples = 4;
  settings.overlays = {.text = settings.overlays.text,
                       .forces = settings.overlays.forces,
                       .contacts = settings.overlays.contacts};
  return settings;
}

}  // namespace

PlanPictures::PlanPictures(const render::Film& film, render::FilmSettings settings)
    : snapshots_(*film.snapshots), painter_(film, ForStills(std::move(settings))) {}

render::Image PlanPictures::Before(const render::PlannedGoal& plan) {
  return painter_.Paint(FrameAt(snapshots_, plan.from));
}

render::Image PlanPictures::Planned(const render::PlannedGoal& plan) {
  return painter_.Paint(FrameAt(snapshots_, plan.from), plan);
}

render::Image PlanPictures::Done(const render::PlannedGoal& plan) {
  return painter_.Paint(FrameAt(snapshots_, plan.until));
}

std::size_t FrameAt(const render::Snapshots& snapshots, Time at) {
  std::size_t frame = 0;
  while (frame + 1 < snapshots.size() && snapshots.time(frame + 1) <= at) ++frame;
  return frame;
}

}  // namespace twin::replay

#include "cli/plan_records.h"

#include "twin/application/end_effector_path.h"
#include "twin/render/renderer.h"

namespace twin::cli {

static_assert(render::Ghost::kMostPoints <= record::PlanRecord::kMostPoints);

record::PlanRecord PlanOf(const application::Snapshot& snapshot) {
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
          .way = application::EndEffectorPath(run.trajectory(), F_T_EE)};
}

}  // namespace twin::cli

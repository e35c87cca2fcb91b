#include "cli/plan_records.h"

#include "twin/application/way.h"
#include "twin/render/renderer.h"

namespace twin::cli {

static_assert(render::Ghost::kMostPoints <= record::PlanRecord::kMostPoints);

record::PlanRecord PlanOf(const application::Moment& moment) {
  return {.id = moment.id,
          .caption = moment.caption,
          .from = moment.planned,
          .until = moment.done,
          .q = moment.goal,
          .way = moment.way,
          .object = moment.object,
          .O_T_object = moment.O_T_object};
}

record::PlanRecord PlanOf(const run::Run& run, const scenario::Scenario& scenario, Time end) {
  const Transform F_T_EE = run.robot().F_T_EE(scenario.onboard.NE_T_EE);
  return {.id = "plan",
          .caption = "Around what stands there to the goal",
          .from = Time(),
          .until = end,
          .q = run.trajectory().goal(),
          .way = application::WayOf(run.trajectory(), F_T_EE)};
}

}  // namespace twin::cli

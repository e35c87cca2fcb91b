#include "cli/plan_pictures.h"

#include "cli/picture.h"
#include "twin/application/way.h"
#include "twin/model/transform.h"
#include "twin/render/frame_painter.h"
#include "twin/render/png.h"

namespace twin::cli {

PlanPictures::PlanPictures(const plant::TruthProbe& truth)
    : truth_(truth), recorder_(kRunsLonger, 1, truth.qpos_size()) {
  recorder_.Capture(Time(), truth);
}

void PlanPictures::Write(const scenario::Run& run, const scenario::Scenario& scenario,
                         const Paths& paths) {
  recorder_.Capture(Time() + kRunsLonger, truth_);
  render::FilmSettings settings = FilmOf(scenario.render);
  settings.render.samples = 4;
  settings.overlays = {.text = false};
  const render::Snapshots& snapshots = recorder_.snapshots();
  render::FramePainter painter({&truth_.model(), &snapshots}, settings);
  render::WritePng(paths.initial, painter.Paint(0));
  const Transform F_T_EE = model::Multiply(run.robot().F_T_NE, scenario.onboard.NE_T_EE.Matrix());
  render::PlannedGoal goal;
  goal.q = run.trajectory().goal();
  goal.way = application::WayOf(run.trajectory(), F_T_EE);
  render::WritePng(paths.plan, painter.Paint(0, goal));
  render::WritePng(paths.final, painter.Paint(snapshots.size() - 1));
}

}  // namespace twin::cli

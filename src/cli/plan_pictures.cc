#include "cli/plan_pictures.h"

#include "cli/picture.h"
#include "twin/application/way.h"
#include "twin/model/transform.h"
#include "twin/render/png.h"
#include "twin/render/renderer.h"

namespace twin::cli {
PlanPictures::PlanPictures(const plant::TruthProbe& truth) : truth_(truth), before_(Positions()) {}

std::vector<double> PlanPictures::Positions() const {
  std::vector<double> qpos(truth_.qpos_size());
  truth_.CopyQpos(qpos);
  return qpos;
}

void PlanPictures::Write(const scenario::Run& run, const scenario::Scenario& scenario,
                         const Paths& paths) const {
  render::RenderSettings settings = PictureOf(scenario.render);
  settings.samples = 4;
  render::Renderer renderer(truth_.model(), settings);
  render::WritePng(paths.initial, renderer.Render(before_));
  const Transform F_T_EE = model::Multiply(run.robot().F_T_NE, scenario.onboard.NE_T_EE.Matrix());
  render::Ghost ghost;
  ghost.qpos = renderer.WithArmAt(before_, run.trajectory().goal());
  ghost.line = application::WayOf(run.trajectory(), F_T_EE);
  render::WritePng(paths.plan, renderer.Render(before_, ghost));
  render::WritePng(paths.final, renderer.Render(Positions()));
}

}  // namespace twin::cli

#include "cli/moment_pictures.h"

#include <cstddef>
#include <string>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/render/frame_painter.h"
#include "twin/render/png.h"

namespace twin::cli {
namespace {

/// The last frame at or before `at`; the first one when there is none.
std::size_t FrameAt(const render::Snapshots& snapshots, Time at) {
  std::size_t frame = 0;
  while (frame + 1 < snapshots.size() && snapshots.time(frame + 1) <= at) ++frame;
  return frame;
}

render::PlannedGoal GoalOf(const application::Moment& moment) {
  return {.from = moment.planned,
          .until = moment.done,
          .q = moment.goal,
          .way = moment.way,
          .object = moment.object,
          .O_T_object = moment.O_T_object};
}

}  // namespace

std::vector<application::MomentPictures> DrawMoments(
    const mjModel_& model, const render::Snapshots& snapshots,
    const std::vector<application::Moment>& moments, render::FilmSettings settings,
    const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw EnvironmentError(
        fmt::format("{}: cannot be made ({})", folder.string(), error.message()));
  }
  settings.render.samples = 4;
  settings.overlays = {.text = false};
  render::FramePainter painter({&model, &snapshots}, settings);
  std::vector<application::MomentPictures> pictures;
  pictures.reserve(moments.size());
  for (const application::Moment& moment : moments) {
    const std::string name = fmt::format("{}_{}", pictures.size() + 1, moment.id);
    const application::MomentPictures pair{.planned = folder / (name + "_plan.png"),
                                           .done = folder / (name + ".png")};
    render::WritePng(pair.planned,
                     painter.Paint(FrameAt(snapshots, moment.planned), GoalOf(moment)));
    render::WritePng(pair.done, painter.Paint(FrameAt(snapshots, moment.done)));
    pictures.push_back(pair);
  }
  return pictures;
}

}  // namespace twin::cli

#include "cli/moment_pictures.h"

#include <cstddef>
#include <span>
#include <string>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/render/png.h"

namespace twin::cli {
namespace {

/// The last frame at or before `at`; the first one when there is none.
std::span<const double> FrameAt(const render::Snapshots& snapshots, Time at) {
  std::size_t frame = 0;
  while (frame + 1 < snapshots.size() && snapshots.time(frame + 1) <= at) ++frame;
  return snapshots.qpos(frame);
}

}  // namespace

std::vector<application::MomentPictures> DrawMoments(
    const mjModel_& model, const render::Snapshots& snapshots,
    const std::vector<application::Moment>& moments, const render::RenderSettings& settings,
    const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw EnvironmentError(
        fmt::format("{}: cannot be made ({})", folder.string(), error.message()));
  }
  render::Renderer renderer(model, settings);
  std::vector<application::MomentPictures> pictures;
  pictures.reserve(moments.size());
  for (const application::Moment& moment : moments) {
    const std::string name = fmt::format("{}_{}", pictures.size() + 1, moment.id);
    const application::MomentPictures pair{.planned = folder / (name + "_plan.png"),
                                           .done = folder / (name + ".png")};
    const std::span<const double> before = FrameAt(snapshots, moment.planned);
    render::Ghost ghost;
    if (moment.goal) ghost.qpos = renderer.WithArmAt(before, *moment.goal);
    if (!moment.object.empty()) {
      ghost.qpos =
          renderer.WithBodyAt(moment.goal ? ghost.qpos : before, moment.object, moment.O_T_object);
    }
    ghost.line = moment.way;
    render::WritePng(pair.planned, renderer.Render(before, ghost));
    render::WritePng(pair.done, renderer.Render(FrameAt(snapshots, moment.done)));
    pictures.push_back(pair);
  }
  return pictures;
}

}  // namespace twin::cli

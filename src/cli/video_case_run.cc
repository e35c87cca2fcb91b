#include "cli/video_case_run.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "cli/picture.h"
#include "cli/say.h"
#include "twin/core/error.h"
#include "twin/render/frame_painter.h"
#include "twin/scenario/data_directory.h"
#include "twin/scenario/states_hash.h"

namespace twin::cli {
namespace {

golden::PicturePlan PlanOf(const scenario::VideoCase& wanted) {
  golden::PicturePlan plan;
  plan.every = wanted.every;
  plan.key_frames = wanted.key_frames;
  for (const scenario::VideoView& view : wanted.views) {
    plan.views.push_back({view.name, FilmOf(view.render)});
  }
  return plan;
}

scenario::RunFiles FilesFor(const VideoFlags& flags, const Host& host) {
  const auto data =
      scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
  if (data.mesh_package.empty()) {
    throw EnvironmentError(
        "the robot's meshes were not found, and pictures that were approved show them; "
        "scripts/setup fetches them, or name them with --meshes");
  }
  return {data.models, data.mesh_package, host.cache, false};
}

}  // namespace

VideoCaseRun::VideoCaseRun(const scenario::VideoCase& wanted, const VideoFlags& flags,
                           const Host& host, const scenario::Catalogue& catalogue)
    : plan_(PlanOf(wanted)) {
  const scenario::RunFiles files = FilesFor(flags, host);
  if (flags.log) {
    log_ = std::filesystem::is_directory(*flags.log) ? *flags.log / "run.mcap" : *flags.log;
  } else {
    Run(wanted, flags, host, catalogue);
  }
  recording_.emplace(log_, files);
  states_ = scenario::StatesHashOf(log_);
}

void VideoCaseRun::Run(const scenario::VideoCase& wanted, const VideoFlags& flags, const Host& host,
                       const scenario::Catalogue& catalogue) {
  RunFlags run;
  run.scenario = FilesFor(flags, host).models / wanted.scenario;
  run.lab = wanted.lab;
  run.seed = wanted.seed;
  run.out = flags.out / wanted.name;
  run.no_video = true;
  run.quiet = true;
  run.data = flags.data;
  log_ = run.out / "run.mcap";
  try {
    static_cast<void>(RunCommand(run, host, catalogue));
  } catch (const RobotFault& fault) {
    Say(stderr,
        fmt::format("panda-twin: note: {}: the run failed: {}\n", wanted.name, fault.what()));
  }
}

void VideoCaseRun::Take(const golden::Golden* golden) {
  std::optional<std::vector<std::size_t>> keys;
  if (golden != nullptr && !golden->pictures.views.empty()) {
    keys.emplace();
    for (const golden::KeyPicture& key : golden->pictures.views[0].keys) keys->push_back(key.frame);
  }
  pictures_ = golden::TakePictures(recording_->Film(), plan_, keys);
}

golden::Evidence VideoCaseRun::Evidence() const {
  const auto look = [this](std::size_t view, std::size_t frame) {
    const render::Film film = recording_->Film();
    render::FramePainter painter(film, plan_.views[view].settings);
    return painter.Segment(golden::FramesOf(film, plan_)[frame]);
  };
  return {&pictures_, states_, look};
}

}  // namespace twin::cli

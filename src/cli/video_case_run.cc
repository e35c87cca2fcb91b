#include "cli/video_case_run.h"

#include <algorithm>
#include <sstream>
#include <vector>

#include <fmt/format.h>

#include "cli/picture.h"
#include "cli/result_folder.h"
#include "cli/run_setup.h"
#include "cli/say.h"
#include "twin/core/error.h"
#include "twin/record/log_reader.h"
#include "twin/render/frame_painter.h"
#include "twin/scenario/data_directory.h"
#include "twin/run/states_hash.h"

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

run::RunFiles FilesFor(const VideoFlags& flags, const Host& host) {
  const auto data =
      scenario::FindDataDirectory({host.executable, flags.data.models, flags.data.meshes});
  if (data.mesh_package.empty()) {
    throw EnvironmentError(
        "the robot's meshes were not found, and pictures that were approved show them; "
        "scripts/setup fetches them, or name them with --meshes");
  }
  return {data.models, data.mesh_package, UsableCache(host), false};
}

/// How the case is run.
RunFlags FlagsOf(const scenario::VideoCase& wanted, const VideoFlags& flags,
                 const run::RunFiles& files) {
  RunFlags run;
  run.scenario = files.models / wanted.scenario;
  run.lab = wanted.lab;
  run.seed = wanted.seed;
  run.out = flags.out / wanted.name;
  run.no_video = true;
  run.quiet = true;
  run.data = flags.data;
  return run;
}

/// Where two texts differ first, in words. @pre they differ.
std::string FirstDifference(const std::string& theirs, const std::string& wanted) {
  std::istringstream left(theirs);
  std::istringstream right(wanted);
  std::string a;
  std::string b;
  while (std::getline(left, a) && std::getline(right, b) && a == b) continue;
  const auto trim = [](const std::string& line) {
    constexpr std::size_t kMost = 100;
    return line.substr(std::min(line.find_first_not_of(" -"), line.size()), kMost);
  };
  return fmt::format("\"{}\", the case's \"{}\"", trim(a), trim(b));
}

/// @returns what a log's run has other than the case, in words; empty: nothing. From where it was
/// filmed is no part of it.
std::string DifferenceOf(scenario::Scenario theirs, scenario::Scenario wanted) {
  if (theirs.name != wanted.name) {
    return fmt::format("its scenario is {}, the case's {}", theirs.name, wanted.name);
  }
  if (theirs.seed != wanted.seed) {
    return fmt::format("its seed is {}, the case's {}", theirs.seed, wanted.seed);
  }
  theirs.render = wanted.render;
  const std::string text = ToYaml(theirs);
  const std::string wanted_text = ToYaml(wanted);
  if (text == wanted_text) return {};
  return "its scenario's text (or lab) is another: " + FirstDifference(text, wanted_text);
}

/// @throws InputError when the log's run is not the case's, or, to approve, is not whole.
void RequireRunOf(const scenario::VideoCase& wanted, const std::filesystem::path& log,
                  const VideoFlags& flags, const run::RunFiles& files, const Host& host) {
  const record::LogReader reader(log);
  if (reader.truncated()) {
    const std::string cut =
        fmt::format("{}: the run was killed, and its last part is missing", log.string());
    if (flags.deed == VideoDeed::kApprove) {
      throw InputError(cut + "; approve the log of a whole run");
    }
    Say(stderr, fmt::format("panda-twin: note: {}\n", cut));
  }
  const std::string& text = reader.run().scenario_yaml;
  if (text.empty()) return;  // nothing can be drawn of such a log: replay::Recording says so
  const std::string difference =
      DifferenceOf(scenario::Parse(text, log.string() + ": scenario.yaml"),
                   LoadWithFlags(FlagsOf(wanted, flags, files), host));
  if (difference.empty()) return;
  throw InputError(
      fmt::format("{}: not a run of the case {}: {}", log.string(), wanted.name, difference));
}

}  // namespace

VideoCaseRun::VideoCaseRun(const scenario::VideoCase& wanted, const VideoFlags& flags,
                           const Host& host, const run::Catalogue& catalogue)
    : file_(flags.goldens / (wanted.name + ".yaml")), plan_(PlanOf(wanted)) {
  const run::RunFiles files = FilesFor(flags, host);
  if (flags.log) {
    log_ = FindLog(*flags.log);
    RequireRunOf(wanted, log_, flags, files, host);
  } else {
    Run(wanted, flags, host, catalogue);
  }
  recording_.emplace(log_, files);
  states_ = run::StatesHashOf(log_);
}

void VideoCaseRun::Run(const scenario::VideoCase& wanted, const VideoFlags& flags, const Host& host,
                       const run::Catalogue& catalogue) {
  const RunFlags run = FlagsOf(wanted, flags, FilesFor(flags, host));
  log_ = run.out / "run.mcap";
  try {
    static_cast<void>(RunCommand(run, host, catalogue));
  } catch (const RobotFault& fault) {
    Say(stderr,
        fmt::format("panda-twin: note: {}: the run failed: {}\n", wanted.name, fault.what()));
  }
}

void VideoCaseRun::Take(const golden::Golden* golden, const InterruptGuard& interrupt) {
  std::optional<std::vector<std::size_t>> keys;
  if (golden != nullptr && !golden->pictures.views.empty()) {
    keys.emplace();
    for (const golden::KeyPicture& key : golden->pictures.views[0].keys) keys->push_back(key.frame);
  }
  try {
    pictures_ = golden::TakePictures(recording_->Film(), plan_, keys,
                                     [&interrupt] { interrupt.ThrowIfInterrupted(); });
  } catch (const InputError& error) {  // a body or camera that the model lacks, say
    throw InputError(fmt::format("{}: {}", file_.string(), error.what()));
  }
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

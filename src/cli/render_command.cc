#include "cli/render_command.h"

#include <array>
#include <cmath>
#include <system_error>

#include <fmt/format.h>

#include "cli/host.h"
#include "cli/interrupt.h"
#include "cli/picture.h"
#include "cli/result_folder.h"
#include "cli/run_setup.h"
#include "cli/say.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/render/clip.h"
#include "twin/render/png.h"
#include "twin/render/video_writer.h"
#include "twin/replay/comparison.h"
#include "twin/replay/layout.h"
#include "twin/replay/recording.h"
#include "twin/replay/time_line.h"
#include "twin/scenario/data_directory.h"

namespace twin::cli {
namespace {

void TellNote(const std::string& note) {
  Say(stderr, fmt::format("panda-twin: note: {}\n", note));
}

std::optional<Time> InstantOf(const std::optional<double>& seconds) {
  if (!seconds) return std::nullopt;
  return Time(Duration(std::llround(*seconds * 1e9)));
}

/// What a log is called in pictures: its folder, or its own name where that says more.
std::string NameOf(const std::filesystem::path& log) {
  const std::filesystem::path folder = std::filesystem::absolute(log).parent_path().filename();
  return (log.stem() == "run" ? folder : log.stem()).string();
}

/// One picture, or a film.
bool IsPicture(const RenderFlags& flags) {
  const bool wanted = flags.at || flags.layout;
  const bool named = flags.out.extension() == ".png";
  if (wanted == named) return wanted;
  throw InputError(named ? "--out: a .png is one picture: say which with --at S or --layout NAME, "
                           "or name a video or a folder"
                         : "--out: --at and --layout make one picture, so name a .png");
}

void RefuseWhatDoesNotGoTogether(const RenderFlags& flags) {
  if (flags.at && (flags.from || flags.until || flags.layout)) {
    throw InputError("--at shows one instant; leave --from, --to and --layout out");
  }
  if ((flags.at || flags.layout) && (flags.fps || flags.speed != 1)) {
    throw InputError("--at and --layout make one picture; leave --fps and --speed out");
  }
  if (flags.tolerance && flags.compare != "difference") {
    throw InputError("--tolerance is for --compare difference; leave it out, or compare so");
  }
  if (flags.layout && flags.second) {
    throw InputError("--layout is of one run; leave the second log out");
  }
  if (flags.layout && (flags.from || flags.until)) {
    throw InputError("--layout takes its instants from the plans; leave --from and --to out");
  }
}

/// Before anything is read or drawn. @throws twin::Error when nothing can be written there.
void RequirePlace(const std::filesystem::path& out, bool picture) {
  std::error_code error;
  if (!picture) {
    render::CheckVideoPath(out);
  } else if (std::filesystem::is_directory(out, error)) {
    throw InputError(
        fmt::format("--out: {} is a folder; name a file that is not there", out.string()));
  }
  const std::filesystem::path folder = (out.has_filename() ? out : out.parent_path()).parent_path();
  TryToWrite(folder.empty() ? "." : folder);
}

/// One rendering, from its flags to its file.
class Rendering {
 public:
  Rendering(const RenderFlags& flags, const Host& host)
      : flags_(flags), picture_(IsPicture(flags)), files_(FilesOf(host)) {
    RefuseWhatDoesNotGoTogether(flags);
    RequirePlace(flags.out, picture_);
    if (!picture_) RequireProgram("ffmpeg", host.path, "apt-get install ffmpeg");
    Read(flags.log, first_);
    if (flags.second) Read(*flags.second, second_);
    settings_ = FilmOf(first_->scenario().render, flags.film);
  }

  void Execute() {
    if (flags_.layout) {
      WritePicture(replay::DrawLayout(*first_, replay::LayoutFromName(*flags_.layout), settings_));
    } else if (second_) {
      DrawBoth();
    } else {
      DrawOne();
    }
  }

 private:
  [[nodiscard]] run::RunFiles FilesOf(const Host& host) const {
    const auto data =
        scenario::FindDataDirectory({host.executable, flags_.data.models, flags_.data.meshes});
    if (data.mesh_package.empty()) {
      TellNote(
          "the robot's meshes were not found; it is drawn in primitive shapes (scripts/setup "
          "fetches them; or name them with --meshes)");
    }
    return {data.models, data.mesh_package, UsableCache(host)};
  }

  void Read(const std::filesystem::path& named, std::optional<replay::Recording>& recording) {
    const std::filesystem::path log = FindLog(named);
    const int least = static_cast<int>(std::ceil(flags_.fps.value_or(0) / flags_.speed));
    recording.emplace(log, files_, std::max(least, 0));
    if (recording->truncated()) {
      TellNote(fmt::format("{}: the run was killed; its last part is missing, and what it planned",
                           log.string()));
    }
    if (recording->source() == replay::FrameSource::kStates) {
      TellNote(fmt::format(
          "{}: it holds no scenes, so the arm moves as it was measured, the hand stays open, and "
          "objects stay where the scenario puts them",
          log.string()));
    } else if (flags_.speed < 1) {
      TellNote(
          fmt::format("{}: scenes were recorded {} times a second; slower, each is shown "
                      "several times",
                      log.string(), recording->snapshots().fps()));
    }
  }

  [[nodiscard]] replay::TimeLine TimeLineOf() const {
    replay::TimeLine line{.from = InstantOf(flags_.at ? flags_.at : flags_.from),
                          .until = InstantOf(flags_.at ? flags_.at : flags_.until),
                          .speed = flags_.speed,
                          .fps = flags_.fps.value_or(first_->scenario().render.fps)};
    return line;
  }

  void DrawOne() {
    const render::Snapshots& scenes = first_->snapshots();
    const replay::TimeLine line = TimeLineOf();
    const render::Snapshots shown = replay::SnapshotsAt(
        scenes, replay::FrameTimes(scenes.time(0), scenes.time(scenes.size() - 1), line), line.fps);
    const render::Snapshots before =
        replay::SnapshotsBefore(scenes, shown.time(0), FromSeconds(settings_.trace_s));
    render::Film film = first_->Film();
    film.snapshots = &shown;
    film.before = &before;
    Write(render::FramesOf(film, settings_));
  }

  void DrawBoth() {
    const replay::Comparison comparison(
        *first_, *second_,
        {.kind = replay::ComparisonFromName(flags_.compare),
         .film = settings_,
         .time_line = TimeLineOf(),
         .tolerance = flags_.tolerance.value_or(replay::ComparisonSettings().tolerance)},
        {NameOf(FindLog(flags_.log)), NameOf(FindLog(*flags_.second))});
    for (const std::string& note : comparison.Notes()) TellNote(note);
    Write(comparison.Frames());
  }

  void WritePicture(const render::Image& image) const {
    interrupt_.ThrowIfInterrupted();
    render::WritePng(flags_.out, image);
  }

  void Write(const render::ClipFrames& frames) {
    if (picture_) {
      WritePicture(frames.new_drawer()(0));
      return;
    }
    ShowClip(frames, {.video = flags_.out, .contact_sheet = {}}, interrupt_, clock_, flags_.quiet);
  }

  const MonotonicClock clock_;
  const InterruptGuard interrupt_;
  const RenderFlags& flags_;
  const bool picture_;
  const run::RunFiles files_;
  std::optional<replay::Recording> first_;  ///< always there after construction
  std::optional<replay::Recording> second_;
  render::FilmSettings settings_;
};

}  // namespace

ExitCode RenderCommand(const RenderFlags& flags, const Host& host) {
  Rendering(flags, host).Execute();
  if (!flags.quiet) Say(stdout, fmt::format("{}\n", flags.out.string()));
  return kOk;
}

}  // namespace twin::cli

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "cli/film_flags.h"
#include "cli/shared_flags.h"
#include "cli/terminal.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/render/clip.h"
#include "twin/render/image.h"
#include "twin/render/video_writer.h"
#include "twin/replay/cell_recording.h"
#include "twin/replay/comparison.h"
#include "twin/replay/layout.h"
#include "twin/replay/recording.h"
#include "twin/replay/time_line.h"
#include "twin/run/result_folder.h"

namespace twin::cli {
namespace {

struct RenderFlags {
  std::filesystem::path log;                    ///< or a run's folder
  std::optional<std::filesystem::path> second;  ///< of another run, to compare with
  std::filesystem::path out;
  FilmFlags film;
  double speed = 1;
  std::optional<int> fps;
  std::optional<double> from;  ///< s of the run, as the following
  std::optional<double> until;
  std::optional<double> at;                       ///< one picture
  std::optional<replay::ComparisonKind> compare;  ///< absent: split
  std::optional<int> tolerance;                   ///< absent: 16
  std::optional<replay::Layout> layout;
  DataFlags data;
};

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
  RefuseIf(flags.at && (flags.from || flags.until || flags.layout),
           "--at shows one instant; leave --from, --to and --layout out");
  RefuseIf((flags.at || flags.layout) && (flags.fps || flags.speed != 1),
           "--at and --layout make one picture; leave --fps and --speed out");
  RefuseIf(flags.tolerance && flags.compare != replay::ComparisonKind::kDifference,
           "--tolerance is for --compare difference; leave it out, or compare so");
  RefuseIf(flags.layout && flags.second, "--layout is of one run; leave the second log out");
  RefuseIf(flags.layout && (flags.from || flags.until),
           "--layout takes its instants from the plans; leave --from and --to out");
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
  run::TryToWrite(folder.empty() ? "." : folder);
}

/// One rendering, from its flags to its file.
class Rendering {
 public:
  Rendering(const RenderFlags& flags, const Program& program)
      : terminal_(program.log, program.is_quiet()),
        flags_(flags),
        picture_(IsPicture(flags)),
        files_(FilesOf(flags.data, program)) {
    if (files_.mesh_package.empty()) {
      terminal_.Note(
          "the robot's meshes were not found; it is drawn in primitive shapes (scripts/setup "
          "fetches them; or name them with --meshes)");
    }
    RefuseWhatDoesNotGoTogether(flags);
    RequirePlace(flags.out, picture_);
    if (!picture_) RequireProgram("ffmpeg", program.host.path, "apt-get install ffmpeg");
    if (replay::IsCellFolder(flags.log)) {
      RefuseIf(flags.second || flags.layout,
               "the folder holds a run of several robots; leave the second log and --layout out, "
               "or name a robot's folder in it");
      cell_.emplace(flags.log, files_);
      settings_ = FilmOf(cell_->cell().common.render, flags.film);
      return;
    }
    Read(flags.log, first_);
    if (flags.second) Read(*flags.second, second_);
    settings_ = FilmOf(first_->scenario().render, flags.film);
  }

  void Execute() {
    if (cell_) {
      DrawOne(cell_->snapshots(), cell_->Film(), cell_->cell().common.render.fps);
    } else if (flags_.layout) {
      WritePicture(replay::DrawLayout(*first_, *flags_.layout, settings_));
    } else if (second_) {
      DrawBoth();
    } else {
      DrawOne(first_->snapshots(), first_->Film(), first_->scenario().render.fps);
    }
  }

 private:
  void Read(const std::filesystem::path& named, std::optional<replay::Recording>& recording) {
    const std::filesystem::path log = run::FindLog(named);
    const int least = static_cast<int>(std::ceil(flags_.fps.value_or(0) / flags_.speed));
    recording.emplace(log, files_, std::max(least, 0));
    if (recording->truncated()) {
      terminal_.Note(fmt::format(
          "{}: the run was killed; its last part is missing, and what it planned", log.string()));
    }
    if (recording->source() == replay::FrameSource::kStates) {
      terminal_.Note(fmt::format(
          "{}: it holds no scenes, so the arm moves as it was measured, the hand stays open, and "
          "objects stay where the scenario puts them",
          log.string()));
    } else if (flags_.speed < 1) {
      terminal_.Note(
          fmt::format("{}: scenes were recorded {} times a second; slower, each is shown "
                      "several times",
                      log.string(), recording->snapshots().fps()));
    }
  }

  /// @param fps  unless the flags say another.
  [[nodiscard]] replay::TimeLine TimeLineOf(int fps) const {
    return {.from = InstantOf(flags_.at ? flags_.at : flags_.from),
            .until = InstantOf(flags_.at ? flags_.at : flags_.until),
            .speed = flags_.speed,
            .fps = flags_.fps.value_or(fps)};
  }

  void DrawOne(const render::Snapshots& scenes, render::Film film, int fps) {
    const replay::TimeLine line = TimeLineOf(fps);
    const render::Snapshots shown = replay::SnapshotsAt(
        scenes, replay::FrameTimes(scenes.time(0), scenes.time(scenes.size() - 1), line), line.fps);
    const render::Snapshots before =
        replay::SnapshotsBefore(scenes, shown.time(0), FromSeconds(settings_.trace_s));
    film.snapshots = &shown;
    film.before = &before;
    Write(render::FramesOf(film, settings_));
  }

  void DrawBoth() {
    const replay::Comparison comparison(
        *first_, *second_,
        {.kind = flags_.compare.value_or(replay::ComparisonKind::kSplit),
         .film = settings_,
         .time_line = TimeLineOf(first_->scenario().render.fps),
         .tolerance = flags_.tolerance.value_or(replay::ComparisonSettings().tolerance)},
        {NameOf(run::FindLog(flags_.log)), NameOf(run::FindLog(*flags_.second))});
    for (const std::string& note : comparison.Notes()) terminal_.Note(note);
    Write(comparison.Frames());
  }

  void WritePicture(const render::Image& image) {
    terminal_.ThrowIfInterrupted();
    render::WritePng(flags_.out, image);
  }

  void Write(const render::ClipFrames& frames) {
    if (picture_) {
      WritePicture(frames.new_drawer()(0));
      return;
    }
    replay::RenderClip(frames, {.video = flags_.out, .contact_sheet = {}}, clock_, terminal_);
  }

  const MonotonicClock clock_;
  Terminal terminal_;
  const RenderFlags& flags_;
  const bool picture_;
  const run::RunFiles files_;
  std::optional<replay::CellRecording> cell_;  ///< of several robots
  std::optional<replay::Recording> first_;     ///< of one; one of the two is there
  std::optional<replay::Recording> second_;
  render::FilmSettings settings_;
};

int Render(const RenderFlags& flags, const Program& program) {
  Rendering(flags, program).Execute();
  if (!program.is_quiet()) Say(stdout, fmt::format("{}\n", flags.out.string()));
  return kOk;
}

/// A number in a range; CLI::Range lets NaN pass.
CLI::Validator Within(double low, double high) {
  const std::string range = fmt::format("[{} - {}]", low, high);
  const auto check = [=](const std::string& text) {
    double value = 0;
    const bool number = CLI::detail::lexical_cast(text, value);
    return number && value >= low && value <= high
               ? std::string()
               : fmt::format("{} is no number in {}", text, range);
  };
  return CLI::Validator(check, "FLOAT in " + range, "");
}

/// Of a run, s: within eleven days.
CLI::Validator Instant() {
  return Within(0, 1e6);
}

}  // namespace

void AddRender(CLI::App& app, Program& program) {
  const auto [render, flags] =
      AddCommand(app, program, "render", "Draw a recorded run, or two beside each other", &Render);
  Add(render, "log FILE|DIR", flags.log, "Log of a run, or its folder of results")->required();
  CLI::Option* second = Add(render, "second FILE|DIR", flags.second, "Of another run, to compare");
  Add(render, "--out FILE", flags.out,
      "Video (.mp4, or .mkv without loss), folder/ of pictures, or a .png with --at "
      "or --layout")
      ->required();
  AddFilm(render, flags.film);
  Add(render, "--speed X", flags.speed, "Seconds of the run in a second of the film")
      ->check(Within(0.01, 100))
      ->capture_default_str();
  Add(render, "--fps N", flags.fps, "Frames per second of the film")->check(CLI::Range(1, 240));
  Add(render, "--from S", flags.from, "Begin at this time of the run")->check(Instant());
  Add(render, "--to S", flags.until, "End at this time of the run")->check(Instant());
  Add(render, "--at S", flags.at, "One picture, of this time of the run")->check(Instant());
  AddParsed(render, "--compare", "HOW", flags.compare,
            "Two runs: split (side by side), ghost, or difference (red where they differ)",
            &replay::ComparisonFromName)
      ->default_str("split")
      ->needs(second);
  Add(render, "--tolerance N", flags.tolerance,
      "difference: how far a channel may be off, of 255 (16)")
      ->check(CLI::Range(0, 254))
      ->needs(second);
  AddParsed(render, "--layout", "NAME", flags.layout, "A page of pictures: grid, strip or triple",
            &replay::LayoutFromName);
  AddData(render, flags.data);
}

}  // namespace twin::cli

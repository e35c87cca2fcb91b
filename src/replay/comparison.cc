#include "twin/replay/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "twin/core/error.h"
#include "twin/render/frame_painter.h"

namespace twin::replay {
namespace {

constexpr std::array<std::pair<std::string_view, ComparisonKind>, 3> kComparisonNames = {
    {{"split", ComparisonKind::kSplit},
     {"ghost", ComparisonKind::kGhost},
     {"difference", ComparisonKind::kDifference}}};

constexpr render::Rgb kHighlight{230, 30, 30};
constexpr render::Rgb kDivider{225, 225, 225};

Time FirstOf(const Recording& recording) {
  return recording.snapshots().time(0);
}

Time LastOf(const Recording& recording) {
  return recording.snapshots().time(recording.snapshots().size() - 1);
}

double LengthOf(const Recording& recording) {
  return ToSeconds(LastOf(recording) - FirstOf(recording));
}

/// One run on the clip's time line, with its captions.
struct Side {
  render::Snapshots snapshots;
  render::Snapshots before;
  render::Film film;

  Side(const Recording& recording, const std::vector<Time>& times,
       const ComparisonSettings& settings, const std::string& label)
      : snapshots(SnapshotsAt(recording.snapshots(), times, settings.time_line.fps)),
        before(SnapshotsBefore(recording.snapshots(), snapshots.time(0),
                               FromSeconds(settings.film.trace_s))),
        film(recording.Film()) {
    film.snapshots = &snapshots;
    film.before = &before;
    film.title = fmt::format("{}\n{}", label, film.title.substr(0, film.title.find('\n')));
    film.notes.push_back({LastOf(recording), "ended"});
  }
  Side(const Side&) = delete;
  Side& operator=(const Side&) = delete;
};

std::vector<Time> Shifted(std::vector<Time> times, Duration by) {
  for (Time& time : times) time += by;
  return times;
}

render::FilmSettings Plain(render::FilmSettings settings) {
  settings.overlays.text = false;
  return settings;
}

}  // namespace

ComparisonKind ComparisonFromName(std::string_view name) {
  for (const auto& [known, kind] : kComparisonNames) {
    if (known == name) return kind;
  }
  throw InputError(fmt::format("there is no {}; choose one of split, ghost, difference", name));
}

class Comparison::Impl {
 public:
  Impl(const Recording& first, const Recording& second, const ComparisonSettings& settings,
       const std::array<std::string, 2>& labels)
      : first_(first),
        second_(second),
        settings_(settings),
        times_(FrameTimes(FirstOf(first), LastOfBoth(), settings.time_line)),
        left_(first, times_, settings, "A: " + labels[0]),
        right_(second, Shifted(times_, FirstOf(second) - FirstOf(first)), settings,
               "B: " + labels[1]) {
    RequireInRange("tolerance", settings_.tolerance, 0, 254);
    if (settings_.kind == ComparisonKind::kGhost && second.scenario().base) {
      throw InputError(
          "a ghost stands where the first run's robot does, and the second run's drives about; "
          "choose split");
    }
    if (settings_.kind == ComparisonKind::kGhost) {
      left_.film.title = fmt::format("{}\nghost: {}", labels[0], labels[1]);
    } else if (settings_.kind == ComparisonKind::kDifference) {
      left_.film.title = fmt::format("{}\nred: not so in {}", labels[0], labels[1]);
    }
  }

  [[nodiscard]] render::ClipFrames Frames() const {
    const render::RenderSettings& picture = settings_.film.render;
    render::ClipFrames frames{.count = times_.size(),
                              .fps = settings_.time_line.fps,
                              .width = picture.width,
                              .height = picture.height,
                              .new_drawer = {}};
    switch (settings_.kind) {
      case ComparisonKind::kSplit:
        frames.width = 2 * picture.width;
        frames.new_drawer = [this] { return NewSplit(); };
        break;
      case ComparisonKind::kGhost: frames.new_drawer = [this] { return NewGhost(); }; break;
      case ComparisonKind::kDifference:
        frames.new_drawer = [this] { return NewDifference(); };
        break;
    }
    return frames;
  }

  [[nodiscard]] std::vector<std::string> Notes() const {
    std::vector<std::string> notes;
    if (LengthOf(first_) != LengthOf(second_)) {
      notes.push_back(
          fmt::format("the first run took {:.3f} s, the second {:.3f} s; who has ended "
                      "stays as it was then",
                      LengthOf(first_), LengthOf(second_)));
    }
    if (first_.scenario().name != second_.scenario().name) {
      notes.push_back(fmt::format("the first is of the scenario {}, the second of {}",
                                  first_.scenario().name, second_.scenario().name));
    }
    if (first_.source() != second_.source()) {
      notes.push_back(fmt::format(
          "of the {} nothing but the arm was recorded: its hand is drawn open, objects where the "
          "scenario puts them",
          first_.source() == FrameSource::kStates ? "first" : "second"));
    }
    return notes;
  }

 private:
  using Painter = render::FramePainter;

  /// The end of the longer run, on the first's clock.
  [[nodiscard]] Time LastOfBoth() const {
    return std::max(LastOf(first_), LastOf(second_) - FirstOf(second_) + FirstOf(first_));
  }

  // Painters are shared only because std::function copies; each has one user.
  [[nodiscard]] render::DrawFrame NewSplit() const {
    return [left = std::make_shared<Painter>(left_.film, settings_.film),
            right = std::make_shared<Painter>(right_.film, settings_.film)](std::size_t frame) {
      return SideBySide(left->Paint(frame), right->Paint(frame));
    };
  }

  [[nodiscard]] render::DrawFrame NewGhost() const {
    return
        [this, painter = std::make_shared<Painter>(left_.film, settings_.film)](std::size_t frame) {
          render::PlannedGoal ghost;
          ghost.q = second_.ArmIn(right_.snapshots.qpos(frame));
          return painter->Paint(frame, ghost);
        };
  }

  [[nodiscard]] render::DrawFrame NewDifference() const {
    return
        [this, shown = std::make_shared<Painter>(left_.film, settings_.film),
         left = std::make_shared<Painter>(left_.film, Plain(settings_.film)),
         right = std::make_shared<Painter>(right_.film, Plain(settings_.film))](std::size_t frame) {
          return HighlightDifference(shown->Paint(frame), left->Paint(frame), right->Paint(frame),
                                     settings_.tolerance);
        };
  }

  const Recording& first_;
  const Recording& second_;
  const ComparisonSettings settings_;
  const std::vector<Time> times_;
  Side left_;
  Side right_;
};

Comparison::Comparison(const Recording& first, const Recording& second,
                       const ComparisonSettings& settings, const std::array<std::string, 2>& labels)
    : impl_(std::make_unique<Impl>(first, second, settings, labels)) {}

Comparison::~Comparison() = default;

render::ClipFrames Comparison::Frames() const {
  return impl_->Frames();
}

std::vector<std::string> Comparison::Notes() const {
  return impl_->Notes();
}

render::Image HighlightDifference(const render::Image& shown, const render::Image& first,
                                  const render::Image& second, int tolerance) {
  render::Image result = shown;
  for (std::size_t i = 0; i < result.rgb.size(); i += 3) {
    int most = 0;
    int sum = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      most = std::max(most, std::abs(first.rgb[c] - second.rgb[c]));
      sum += shown.rgb[c];
    }
    for (std::size_t c = 0; c < 3; ++c) {
      result.rgb[i + c] =
          most > tolerance ? kHighlight[c] : static_cast<std::uint8_t>((sum + 1) / 3);
    }
  }
  return result;
}

render::Image SideBySide(const render::Image& left, const render::Image& right) {
  render::Image both(left.width + right.width, left.height, kDivider);
  for (int row = 0; row < both.height; ++row) {
    const auto to = both.Row(row);
    const auto middle = static_cast<std::ptrdiff_t>(left.Row(row).size());
    std::ranges::copy(left.Row(row).first(static_cast<std::size_t>(middle) - 3), to.begin());
    std::ranges::copy(right.Row(row).subspan(3), to.begin() + middle + 3);
  }
  return both;
}

}  // namespace twin::replay

#include "twin/replay/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "twin/core/error.h"
#include "twin/render/image_operations.h"
#include "twin/replay/plan_pictures.h"

namespace twin::replay {
namespace {

constexpr std::array<std::pair<std::string_view, Layout>, 3> kLayoutNames = {
    {{"grid", Layout::kGrid}, {"strip", Layout::kStrip}, {"triple", Layout::kTriple}}};

constexpr std::size_t kStripPlans = 6;

Vector3 Minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double Dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double DistanceFromSegment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 along = Minus(b, a);
  const double squared = Dot(along, along);
  const double share = squared > 0 ? std::clamp(Dot(Minus(p, a), along) / squared, 0.0, 1.0) : 0.0;
  Vector3 off = Minus(p, a);
  for (std::size_t i = 0; i < off.size(); ++i) off[i] -= share * along[i];
  return std::sqrt(Dot(off, off));
}

/// Draws pictures of a recording, each with its own caption.
class Page {
 public:
  Page(const Recording& recording, const render::FilmSettings& settings)
      : settings_(settings), film_(recording.Film()) {
    film_.notes.clear();
  }

  [[nodiscard]] const render::Film& film() const noexcept { return film_; }
  render::FilmSettings& settings() noexcept { return settings_; }

  [[nodiscard]] PlanPictures Titled(const std::string& title) const {
    render::Film film = film_;
    const auto most = static_cast<std::size_t>(std::max(8, settings_.render.width / 11 - 2));
    std::string line;
    for (const char c : title) {  // cut each line to the picture's width
      const std::size_t begin = line.find_last_of('\n') + 1;
      if (c == '\n' || line.size() - begin < most) line += c;
    }
    film.title = line;
    return {film, settings_};
  }

 private:
  render::FilmSettings settings_;
  render::Film film_;
};

[[noreturn]] void LacksPlans(const Recording& recording, std::string_view wanted) {
  std::vector<std::string_view> ids;
  for (const record::PlanRecord& plan : recording.plans()) ids.push_back(plan.id);
  throw InputError(
      fmt::format("layout: it takes {}; the log of {} has {}", wanted, recording.run().scenario,
                  ids.empty() ? "none: it is of a run without any, or of one that was killed"
                              : fmt::format("only {}", fmt::join(ids, ", "))));
}

/// The frame of the largest distance of the end effector from a plan's path, and that distance.
std::pair<std::size_t, double> Furthest(const Recording& recording,
                                        const record::PlanRecord& plan) {
  const std::size_t first = FrameAt(recording.snapshots(), plan.from);
  const std::size_t last = FrameAt(recording.snapshots(), plan.until);
  const std::vector<Vector3> path =
      plan.path.empty() ? std::vector<Vector3>{recording.ToolAt(first)} : plan.path;
  std::pair<std::size_t, double> furthest{first, 0};
  for (std::size_t frame = first; frame <= last; ++frame) {
    const double distance = DistanceFromPath(recording.ToolAt(frame), path);
    if (distance > furthest.second) furthest = {frame, distance};
  }
  return furthest;
}

render::Image DrawGrid(const Recording& recording, Page page) {
  constexpr double kArrow = 0.03;  // 30 cm for a push of 10 N, so that the hand does not hide it
  page.settings().overlays = {.text = page.settings().overlays.text, .forces = true};
  page.settings().newton_m = kArrow;
  std::vector<render::Image> pictures;
  for (const std::string_view id : {"A", "B", "C", "D"}) {
    const auto plan = std::ranges::find(recording.plans(), id, &record::PlanRecord::id);
    if (plan == recording.plans().end()) LacksPlans(recording, "the plans A, B, C and D");
    const auto [frame, distance] = Furthest(recording, *plan);
    const std::string what = plan->caption.substr(0, plan->caption.find(';'));
    render::PlannedGoal shown;
    shown.from = recording.snapshots().time(frame);
    shown.path = plan->path;
    pictures.push_back(
        page.Titled(fmt::format("{}\n{:.1f} mm off", what, 1e3 * distance)).Planned(shown));
  }
  return render::ComposeContactSheet(pictures, {.columns = 2});
}

render::Image DrawStrip(const Recording& recording, const Page& page) {
  const std::vector<render::PlannedGoal>& goals = page.film().goals;
  if (goals.size() < kStripPlans) LacksPlans(recording, "six plans");
  std::vector<render::Image> above;
  std::vector<render::Image> below;
  for (const std::size_t n : render::SpreadFrames(goals.size(), kStripPlans)) {
    PlanPictures pictures =
        page.Titled(fmt::format("{} {}", above.size() + 1, recording.plans()[n].id));
    above.push_back(pictures.Planned(goals[n]));
    below.push_back(pictures.Done(goals[n]));
  }
  std::ranges::move(below, std::back_inserter(above));
  return render::ComposeContactSheet(above, {.columns = kStripPlans});
}

render::Image DrawTriple(const Recording& recording, const Page& page) {
  const std::vector<render::PlannedGoal>& goals = page.film().goals;
  if (goals.empty()) LacksPlans(recording, "a plan");
  std::vector<render::Image> pictures;
  for (std::size_t i = 0; i < goals.size(); ++i) {
    const std::string id = goals.size() == 1 ? "" : recording.plans()[i].id + ": ";
    pictures.push_back(page.Titled(id + "initial").Before(goals[i]));
    pictures.push_back(page.Titled(id + "plan").Planned(goals[i]));
    pictures.push_back(page.Titled(id + "final").Done(goals[i]));
  }
  return render::ComposeContactSheet(pictures, {.columns = 3});
}

}  // namespace

Layout LayoutFromName(std::string_view name) {
  for (const auto& [known, layout] : kLayoutNames) {
    if (known == name) return layout;
  }
  throw InputError(fmt::format("there is no {}; choose one of grid, strip, triple", name));
}

double DistanceFromPath(const Vector3& point, std::span<const Vector3> path) {
  double least = DistanceFromSegment(point, path.front(), path.front());
  for (std::size_t i = 1; i < path.size(); ++i) {
    least = std::min(least, DistanceFromSegment(point, path[i - 1], path[i]));
  }
  return least;
}

render::Image DrawLayout(const Recording& recording, Layout layout,
                         const render::FilmSettings& settings) {
  const Page page(recording, settings);
  switch (layout) {
    case Layout::kGrid: return DrawGrid(recording, page);
    case Layout::kStrip: return DrawStrip(recording, page);
    case Layout::kTriple: break;
  }
  return DrawTriple(recording, page);
}

}  // namespace twin::replay

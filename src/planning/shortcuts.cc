#include "planning/shortcuts.h"

#include <algorithm>
#include <cstddef>

#include "planning/joint_space.h"
#include "twin/core/random.h"

namespace twin::planning {
namespace {

/// A point on a path: a share of a segment.
struct Place {
  std::size_t segment = 0;
  JointVector q{};
};

Place PlaceAt(const std::vector<JointVector>& path, double length) {
  for (std::size_t i = 0; i + 2 < path.size(); ++i) {
    const double along = Distance(path[i], path[i + 1]);
    if (length < along) return {i, Between(path[i], path[i + 1], length / along)};
    length -= along;
  }
  const JointVector& a = path[path.size() - 2];
  const JointVector& b = path.back();
  const double along = Distance(a, b);
  return {path.size() - 2, Between(a, b, along > 0 ? std::clamp(length / along, 0.0, 1.0) : 0)};
}

/// Removes each turning point that is not needed.
void DropPoints(std::vector<JointVector>& path, MotionChecker& checker, std::uint64_t keep_checks) {
  for (std::size_t i = 1; i + 1 < path.size();) {
    if (checker.left() <= keep_checks) return;
    if (checker.IsFree(path[i - 1], path[i + 1])) {
      path.erase(path.begin() + static_cast<std::ptrdiff_t>(i));
      i = std::max<std::size_t>(1, i - 1);
    } else {
      ++i;
    }
  }
}

/// Shorter segments are not worth a turning point, rad.
constexpr double kLeastGain = 1e-3;

}  // namespace

void Shorten(std::vector<JointVector>& path, MotionChecker& checker, std::uint64_t seed,
             const ShortcutEffort& effort) {
  const Random random(seed, RandomStream::kPlannerShortcut);
  DropPoints(path, checker, effort.keep_checks);
  for (int attempt = 0; attempt < effort.attempts && path.size() > 2; ++attempt) {
    if (checker.left() <= effort.keep_checks) return;
    const double length = Length(path);
    const auto tick = static_cast<std::uint64_t>(attempt);
    const auto [first, second] =
        std::minmax({length * random.Uniform(tick, 0), length * random.Uniform(tick, 1)});
    const Place a = PlaceAt(path, first);
    const Place b = PlaceAt(path, second);
    if (a.segment == b.segment) continue;
    if (second - first - Distance(a.q, b.q) < kLeastGain) continue;
    // `a` lies between checked points and may have less than the clearance.
    if (!checker.IsFree(a.q) || !checker.IsFree(a.q, b.q)) continue;
    const auto from = path.begin() + static_cast<std::ptrdiff_t>(a.segment) + 1;
    const auto to = path.begin() + static_cast<std::ptrdiff_t>(b.segment) + 1;
    const auto at = path.erase(from, to);
    path.insert(at, {a.q, b.q});
  }
  DropPoints(path, checker, effort.keep_checks);
}

}  // namespace twin::planning
